"""Converged modes of ``disc_pad``: mortar, refined until both backends agree.

No exact solution is known. Each backend runs two discretisations, the second of higher degree,
graded towards the clamped corners and the boundary of the contact; what both backends share on
their second ones is held to be right, and the change from one to the next says which of them is
nearer. The result is stored with the project (:func:`stored_reference`).
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from math import floor, log10, pi, tau
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cea.contact.formulations import Mortar
from cea.eigen.mode_matching import GroupMatch
from comparisons.kit.progress import Progress
from comparisons.kit.run_warnings import Run, merged_warnings
from meshes.breaks import graded
from scenes.read import Scene, load_scene
from scenes.results import ModesResult
from scenes.run import run_modes
from scenes.run_matching import match_runs
from scenes.spec.body import Backend
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.stored import read_record, record
from scenes.variants import on_backend, with_contact

REFERENCE = Path(__file__).parent / "disc_pad_reference.json"
"""The stored reference."""

GROWTH = 10.0
"""Growth rate (1/s) above which digits of it are asked for."""
_BOUNDARY = {"r": (0.09, 0.14), "theta": (25.0, 65.0)}
"""Boundary of the contact: coordinates of the pad's sides."""
_MEAN_RADIUS = 0.115
_MAX_DIGITS = 15


@dataclass(frozen=True)
class Grading:
    """Sizes of the elements of disc and pad, in m but for angles in degrees.

    Parameters
    ----------
    degree
        Degree of the elements.
    corner
        Size at the clamped rim's corners, of elements that run through the whole disc.
    boundary
        Size at the boundary of the contact.
    disc, pad
        Largest sizes along r, theta, z.
    growth
        Increase of the size with the distance from a corner or the boundary.
    layers
        Layers towards the corners in the Lagrange cells at them alone.
    """

    degree: int
    corner: float
    boundary: float
    disc: tuple[float, float, float]
    pad: tuple[float, float, float]
    growth: float = 1.0
    layers: int = 0


LEVELS: Mapping[Backend, tuple[Grading, Grading]] = {
    "iga": (
        Grading(4, 1e-4, 3e-3, (0.014, 8.0, 0.004), (0.012, 6.0, 0.006), 1.2),
        Grading(5, 5e-5, 3e-3, (0.014, 8.0, 0.004), (0.012, 6.0, 0.006), 1.2),
    ),
    "fe": (
        Grading(3, 0.012, 6e-3, (0.020, 9.0, 0.012), (0.020, 10.0, 0.008), 2.0, layers=3),
        Grading(4, 0.012, 6e-3, (0.020, 9.0, 0.012), (0.020, 10.0, 0.008), 2.0, layers=4),
    ),
}
"""A coarser and a finer mesh for each backend."""


def compute_reference(
    progress: Progress, levels: Mapping[Backend, tuple[Grading, Grading]] = LEVELS
) -> dict[str, Any]:
    """Run every level and compare the finest of both backends, mode by mode.

    Parameters
    ----------
    progress
        Told what is being run.
    levels
        A coarser and a finer mesh for each backend.

    Returns
    -------
    dict
        Record with ``modes``: frequency and growth rate of both backends, the digits they share,
        the change from coarse to fine of each; ``runs``; ``alone``: modes one backend has for
        itself.
    """
    start = perf_counter()
    finest: dict[Backend, ModesResult] = {}
    changes: dict[Backend, dict[int, tuple[float, float]]] = {}
    runs, told = [], list[Run]()
    for backend, pair in levels.items():
        results = []
        for grading in pair:
            scene = graded_scene(backend, grading)
            meshes = {name: _elements(body.mesh, backend) for name, body in scene.bodies.items()}
            progress.step(f"disc and pad, {backend}, degree {grading.degree}, {meshes}")
            results.append(run_modes(scene, listener=progress.stage))
            runs.append(_run(results[-1], backend, grading, meshes))
            point = {"backend": backend, "degree": grading.degree}
            told.append((point, [warning.plain() for warning in results[-1].warnings]))
        coarse, finest[backend] = results
        changes[backend] = _changes(coarse, finest[backend])
    match = match_runs(finest["iga"], finest["fe"])
    data = {
        "modes": sorted((_mode(g, changes) for g in match.groups), key=lambda m: m["frequency"]),
        "alone": {
            "iga": _values(finest["iga"], match.only_first),
            "fe": _values(finest["fe"], match.only_second),
        },
        "runs": runs,
    }
    inputs = {"levels": {b: [asdict(grading) for grading in pair] for b, pair in levels.items()}}
    seconds, warnings = perf_counter() - start, merged_warnings(told, "runs")
    return record("reference", data, inputs=inputs, seconds=seconds, warnings=warnings)


def stored_reference() -> dict[str, Any]:
    """The reference that comes with the project."""
    return read_record(REFERENCE)


def graded_scene(backend: Backend, grading: Grading) -> Scene:
    """``disc_pad`` with mortar contact on graded meshes."""
    scene = with_contact(on_backend(load_scene(Path("disc_pad")), backend), formulation=Mortar())
    disc, pad = scene.bodies["disc"], scene.bodies["pad"]
    turn = grading.boundary / _MEAN_RADIUS * 180 / pi
    fine = {
        "r": dict.fromkeys(_BOUNDARY["r"], grading.boundary),
        "theta": dict.fromkeys(_BOUNDARY["theta"], turn),
    }
    disc_r, _, disc_z = (dict(zip(("low", "high"), e, strict=True)) for e in disc.geometry.extent)
    pad_z = disc_z["high"], pad.geometry.extent[2][1]
    growth = grading.growth
    disc_breaks = (
        graded(
            (disc_r["low"], *_BOUNDARY["r"], disc_r["high"]),
            grading.disc[0],
            fine["r"] | {disc_r["low"]: grading.corner},
            growth,
        ),
        graded(
            (0.0, 25.0, 65.0, 90.0, 180.0, 270.0, 360.0), grading.disc[1], fine["theta"], growth
        ),
        graded(
            tuple(disc_z.values()),
            grading.disc[2],
            dict.fromkeys(disc_z.values(), grading.corner),
            growth,
        ),
    )
    pad_breaks = (
        graded(_BOUNDARY["r"], grading.pad[0], fine["r"], growth),
        graded(_BOUNDARY["theta"], grading.pad[1], fine["theta"], growth),
        graded(pad_z, grading.pad[2], dict.fromkeys(pad_z, grading.boundary), growth),
    )
    bodies = {
        name: replace(scene.bodies[name], mesh=_mesh(backend, grading.degree, breaks))
        for name, breaks in (("pad", pad_breaks), ("disc", disc_breaks))
    }
    whole = bodies["disc"].mesh.fe
    if grading.layers and whole is not None:
        edges = tuple({"r": disc_r["low"], "z": z} for z in disc_z.values())
        layered = replace(whole, edges=edges, layers=grading.layers)
        bodies["disc"] = replace(disc, mesh=MeshSpec(fe=layered))
    return replace(scene, bodies=bodies)


def _mesh(backend: Backend, degree: int, breaks: tuple[Any, ...]) -> MeshSpec:
    elements = tuple(len(each) - 1 for each in breaks)
    through = {
        name: tuple(float(x) for x in each[1:-1])
        for name, each in zip(("r", "theta", "z"), breaks, strict=True)
    }
    if backend == "fe":
        return MeshSpec(fe=FeMesh("hexahedron", degree, elements=elements, through=through))
    return MeshSpec(iga=IgaMesh((degree,) * 3, elements, through=through))


def _elements(mesh: MeshSpec, backend: Backend) -> str:
    chosen = mesh.fe if backend == "fe" else mesh.iga
    assert chosen is not None
    assert chosen.elements is not None
    return " x ".join(map(str, chosen.elements))


def _run(
    result: ModesResult, backend: Backend, grading: Grading, meshes: Mapping[str, str]
) -> dict[str, Any]:
    return {
        "backend": backend,
        "grading": asdict(grading),
        "meshes": dict(meshes),
        "dofs": result.system.size,
        "seconds": result.timer.total,
        "timings": dict(result.timer.seconds),
        "modes": _values(result, np.arange(len(result.modes))),
    }


def _values(result: ModesResult, modes: Any) -> list[dict[str, float]]:
    return [
        {"frequency": float(v.imag / tau), "growth": float(v.real)}
        for v in result.eigenvalues[modes]
    ]


def _changes(coarse: ModesResult, fine: ModesResult) -> dict[int, tuple[float, float]]:
    """Relative change of frequency and change of growth rate (1/s), by mode of the fine run."""
    changes = {}
    for each in match_runs(coarse, fine).groups:
        old, new = each.means
        for mode in each.second:
            changes[int(mode)] = (abs(old.imag / new.imag - 1), abs(old.real - new.real))
    return changes


def _mode(
    pair: GroupMatch, changes: Mapping[Backend, Mapping[int, tuple[float, float]]]
) -> dict[str, Any]:
    """One mode, or a group that nearly coalesces: means of both backends and what they share."""
    iga, fe = pair.means
    nothing = (float("nan"), float("nan"))
    sides: tuple[tuple[Backend, Any], ...] = (("iga", pair.first), ("fe", pair.second))
    change = {backend: changes[backend].get(int(m[0]), nothing) for backend, m in sides}
    known = {b: [None if np.isnan(v) else v for v in c] for b, c in change.items()}
    return {
        "members": len(pair.second),
        "frequency": iga.imag / tau,
        "growth": iga.real,
        "frequency_fe": fe.imag / tau,
        "growth_fe": fe.real,
        "assurance": pair.assurance,
        "digits_frequency": shared_digits(iga.imag, fe.imag),
        "digits_growth": shared_digits(iga.real, fe.real) if abs(iga.real) > GROWTH else None,
        "change_iga": known["iga"],
        "change_fe": known["fe"],
    }


def shared_digits(x: float, y: float) -> int:
    """Significant digits two numbers share: they differ by less than half a unit in the last."""
    if x == y:
        return _MAX_DIGITS
    if y == 0:
        return 0
    return max(0, floor(floor(log10(abs(y))) + 1 - log10(2 * abs(x - y))))
