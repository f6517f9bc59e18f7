"""Converged modes of ``disc_pad``: mortar, refined until both backends agree.

No exact solution is known. Each backend runs two discretisations, the second of higher degree,
graded towards the clamped corners and the boundary of the contact; what both backends share on
their second ones is held to be right, and the change from one to the next says which of them is
nearer. The result is stored with the project.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import floor, log10, pi, tau
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from cea.contact.formulations import Mortar
from cea.eigen.matching import GroupMatch
from comparisons.study.columns import Column
from comparisons.study.numbers import number, shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case, Study
from meshes.breaks import graded
from scenes import Result
from scenes.results.matching import match_runs
from scenes.spec.body import Backend, FeMesh, IgaMesh, MeshSpec
from scenes.spec.reading import Scene, load_scene, on_backend, with_contact

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


@dataclass(frozen=True)
class Options:
    """Options of the study.

    Parameters
    ----------
    levels
        A coarser and a finer mesh for each backend.
    """

    levels: Mapping[Backend, tuple[Grading, Grading]] = field(default_factory=lambda: LEVELS)


def cases(options: Options) -> Iterator[Case]:
    """All levels together: they are compared."""
    yield {"scene": "disc_pad"}


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Every level; modes of the finest of both backends beside each other."""
    finest: dict[Backend, Result] = {}
    changes: dict[Backend, dict[int, tuple[float, float]]] = {}
    runs, modes = [], []
    for backend, pair in session.options.levels.items():
        results = []
        for grading in pair:
            scene = graded_scene(backend, grading)
            meshes = {name: _elements(body.mesh, backend) for name, body in scene.bodies.items()}
            session.stage(f"{backend}, degree {grading.degree}, {meshes}")
            result = session.solve(scene)
            labels = {"backend": backend, "degree": grading.degree}
            runs.append(labels | meshes | {"dofs": result.dofs, "seconds": result.timer.total})
            modes += [labels | value for value in _values(result, np.arange(len(result.modes)))]
            results.append(result)
        coarse, finest[backend] = results
        changes[backend] = _changes(coarse, finest[backend])
    match = match_runs(finest["iga"], finest["fe"])
    lone: list[tuple[Backend, Any]] = [("iga", match.only_first), ("fe", match.only_second)]
    alone = [{"backend": b} | v for b, numbers in lone for v in _values(finest[b], numbers)]
    found = sorted((_mode(g, changes) for g in match.groups), key=lambda m: m["frequency"])
    return {"modes": found, "alone": alone, "runs": runs, "run_modes": modes}


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


def _values(result: Result, modes: Any) -> list[dict[str, float]]:
    return [
        {"frequency": float(v.imag / tau), "growth": float(v.real)}
        for v in result.eigenvalues[modes]
    ]


def _changes(coarse: Result, fine: Result) -> dict[int, tuple[float, float]]:
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
    known = {
        f"change_{b}{what}": None if np.isnan(v) else v
        for b, c in change.items()
        for what, v in zip(("", "_growth"), c, strict=True)
    }
    return {
        "members": len(pair.second),
        "frequency": iga.imag / tau,
        "growth": iga.real,
        "frequency_fe": fe.imag / tau,
        "growth_fe": fe.real,
        "assurance": pair.assurance,
        "digits_frequency": shared_digits(iga.imag, fe.imag),
        "digits_growth": shared_digits(iga.real, fe.real) if abs(iga.real) > GROWTH else None,
        **known,
    }


def shared_digits(x: float, y: float) -> int:
    """Significant digits two numbers share: they differ by less than half a unit in the last."""
    if x == y:
        return _MAX_DIGITS
    if y == 0:
        return 0
    return max(0, floor(floor(log10(abs(y))) + 1 - log10(2 * abs(x - y))))


def table(name: str) -> Any:
    """Makes the frame of a table."""
    return lambda result: result.frame(name).drop(columns="scene", errors="ignore")


def converged(result: StudyResult) -> pd.DataFrame:
    """Modes of both backends, the digits they share, the last changes."""
    frame: pd.DataFrame = table("modes")(result)
    return frame[list(OWN)]


def headline(result: StudyResult) -> str:
    """How many digits both backends share at least."""
    frame = table("modes")(result)
    return (
        f"{frame['members'].sum()} modes; both backends share {frame['digits_frequency'].min()} "
        f"digits of each frequency or more, and {frame['digits_growth'].min():g} of each "
        f"growth rate above {GROWTH:g} 1/s; {len(result.frame('alone'))} modes have no partner."
    )


OWN = {
    "frequency": Column("NURBS", "Hz", shown(7)),
    "frequency_fe": Column("Lagrange", "Hz", shown(7)),
    "digits_frequency": Column("digits", show=number),
    "growth": Column("NURBS growth", "1/s", shown(5)),
    "growth_fe": Column("Lagrange growth", "1/s", shown(5)),
    "digits_growth": Column("digits", show=number),
    "change_iga": Column("change, NURBS", show=shown(1)),
    "change_fe": Column("change, Lagrange", show=shown(1)),
}
SECTION = Section(
    "Modes",
    "Mortar, P = 1e9 N/m, mu = 0.7: means of groups that nearly coalesce. Digits are those both "
    "backends share; changes are those of the last refinement.",
    headline,
    [
        Table("disc_pad_reference", "Converged modes.", converged, OWN, printed=True),
        Table("alone", "Modes without a partner.", table("alone")),
        Table("levels", "Every run.", table("runs")),
        Table("level_modes", "", table("run_modes"), shown=False),
    ],
)
COARSE = Grading(2, 0.02, 0.02, (0.02, 30.0, 0.012), (0.03, 20.0, 0.015))
"""Elements of a quick study; the finer ones have a degree more."""
_QUICK = COARSE, replace(COARSE, degree=3)
STUDY = Study(
    name="reference",
    title="Converged modes of the disc and pad",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    sections=[SECTION],
    quick={"levels": {"iga": _QUICK, "fe": _QUICK}},
    shipped=Path(__file__).with_name("results"),
)
