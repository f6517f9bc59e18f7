"""The main comparison: both scenes on both backends with every formulation, and the disc alone."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.body import Body
from cea.contact.formulations import Formulation, GaussPointToSurface, Greville, Grid, NodeToSurface
from cea.timing import StageTimer
from comparisons.agreement.time_saved import time_saved
from comparisons.kit.progress import Progress
from comparisons.kit.run_warnings import Run, merged_warnings
from scenes.build import build_bodies
from scenes.describe import describe
from scenes.read import load_scene
from scenes.results import ModesResult, StaticResult
from scenes.run import run_modes, run_scene
from scenes.run_matching import match_unstable
from scenes.spec.body import Backend
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.stored import record
from scenes.variants import BACKENDS, on_backend, with_contact

EXPECTED_OSCILLATION = {
    ("greville", 25, 1e14): 1722.0,
    ("greville", 25, 1e6): 3233.0,
    ("grid", 81, 1e6): 1678.0,
    ("gpts", 2025, 1e6): 0.446,
    ("gpts", 5625, 1e6): 0.116,
}
"""Oscillation of sigma_n (N/m^2) on the worse side of the NURBS patch test, from an independent
prototype: by formulation, number of points and P (N/m)."""


def formulations(backend: Backend, grid: int, gauss: Iterable[int]) -> list[Formulation]:
    """Collocation in the manner of the backend, a grid, and GPTS with several point numbers."""
    collocation = NodeToSurface() if backend == "fe" else Greville()
    return [collocation, Grid(grid), *(GaussPointToSurface(n) for n in gauss)]


def compare(progress: Progress) -> tuple[dict[str, Any], Sequence[ModesResult]]:
    """Run everything.

    Returns
    -------
    dict
        Record for ``result.json``.
    list
        The results of the runs of the disc and pad, for pictures and shapes.
    """
    start = perf_counter()
    warm_up(progress)
    data: dict[str, Any] = {"patch_test": patch_test(progress), "disc_alone": disc_alone(progress)}
    data["disc_pad"], results = disc_pad(progress)
    data["time_saved"] = time_saved(progress)
    made = record(
        "compare",
        data,
        inputs={"scenes": ["patch_test", "disc", "disc_pad"]},
        seconds=perf_counter() - start,
        warnings=warnings_of(data),
    )
    return made, results


def warnings_of(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Warnings of all runs of the record, merged."""
    told: list[Run] = []
    for scene in ("patch_test", "disc_alone", "disc_pad"):
        for run in data[scene]["runs"]:
            point = {"scene": scene, "backend": run["backend"]}
            point |= {name: run[name] for name in ("formulation", "P", "mesh") if name in run}
            told.append((point, run["warnings"]))
    return merged_warnings(told, "runs")


def _described(result: ModesResult | StaticResult) -> dict[str, Any]:
    """A run as plain data with its warnings."""
    return describe(result) | {"warnings": [warning.plain() for warning in result.warnings]}


def warm_up(progress: Progress) -> None:
    """Compile finite element forms once, so that no run is charged for it."""
    progress.step("compile finite element forms")
    scene = on_backend(load_scene(Path("disc_pad")), "fe")
    for kind in ("hexahedron", "tetrahedron"):
        mesh = FeMesh(kind, elements=(1, 4, 1)) if kind == "hexahedron" else FeMesh(kind, size=0.05)
        disc = replace(scene.bodies["disc"], mesh=MeshSpec(fe=mesh))
        run_scene(replace(scene, bodies={"disc": disc}, contacts={}), listener=progress.stage)


def patch_test(progress: Progress) -> dict[str, Any]:
    """Oscillation of sigma_n for every formulation on both backends."""
    runs = []
    for backend in BACKENDS:
        scene = on_backend(load_scene(Path("patch_test")), backend)
        bodies = build_bodies(scene, StageTimer(progress.stage))
        grid = 9 if backend == "iga" else 4
        for formulation in formulations(backend, grid, (15, 25)):
            for P in (1e6, 1e14):
                progress.step(f"patch test, {backend}, {formulation.method}, P = {P:g}")
                variant = with_contact(scene, formulation=formulation, P=P)
                run = _described(run_scene(variant, bodies=bodies, listener=progress.stage))
                runs.append(run | _labels(backend, formulation, run) | {"P": P})
    for run in runs:
        sides = run["stresses"]["interface"].values()
        run["oscillation"] = max(side["oscillation"] for side in sides)
        key = (run["method"], run["points"], run["P"])
        run["expected"] = EXPECTED_OSCILLATION.get(key) if run["backend"] == "iga" else None
    return {"exact_sigma_n": -1000.0, "runs": runs}


RIM = 0.06
"""Inner radius of the disc (m), where its clamped corners hold a singularity."""


def _graded(*distances: float) -> dict[str, tuple[float, ...]]:
    """Element boundaries at given distances (m) from the clamped rim."""
    return {"r": tuple(RIM + d for d in distances)}


DISC_MESHES: dict[str, list[FeMesh | IgaMesh]] = {
    "hexahedra, degree 2": [
        FeMesh("hexahedron", 2, elements=(n, 8 * n, max(1, n // 3))) for n in (3, 5, 8, 11)
    ],
    "hexahedra, degree 2, graded to the rim": [
        FeMesh("hexahedron", 2, elements=(4, 24, 1), through=_graded(0.006)),
        FeMesh("hexahedron", 2, elements=(6, 32, 2), through=_graded(0.002, 0.008)),
        FeMesh("hexahedron", 2, elements=(9, 48, 3), through=_graded(0.0005, 0.002, 0.006)),
    ],
    "tetrahedra, degree 2": [FeMesh("tetrahedron", 2, size=h) for h in (0.02, 0.012, 0.008)],
    "NURBS, degree 2": [IgaMesh((2, 2, 2), (n, 8 * n, max(1, n // 3))) for n in (3, 5, 8, 11, 15)],
    "NURBS, degree 3, graded to the rim": [
        IgaMesh((3, 3, 3), (4, 16, 1), through=_graded(0.006)),
        IgaMesh((3, 3, 3), (6, 24, 2), through=_graded(0.002, 0.008)),
        IgaMesh((3, 3, 3), (9, 32, 3), through=_graded(0.0005, 0.002, 0.006)),
    ],
    "NURBS, degree 4": [IgaMesh((4, 4, 4), (n, 8 * n, 1)) for n in (2, 4, 6)],
}
"""Meshes of the disc alone: lines of the plot of error against run time, rising in cost."""

DISC_REFERENCE = IgaMesh(
    (4, 4, 4),
    (11, 32, 6),
    through={
        "r": (0.0602, 0.0606, 0.0615, 0.0635, 0.068),
        "z": (0.0005, 0.002, 0.01, 0.0115),
    },
)
"""Reference of the disc alone: graded towards both clamped corners."""

_DISC_MODES = 20


def disc_alone(progress: Progress) -> dict[str, Any]:
    """First frequencies of the disc without pad: both backends against one finer reference."""
    scene = load_scene(Path("disc"))

    def run(line: str, mesh: FeMesh | IgaMesh) -> dict[str, Any]:
        progress.step(f"disc alone, {line}, {_mesh_words(mesh)}")
        backend: Backend = "fe" if isinstance(mesh, FeMesh) else "iga"
        disc = replace(scene.bodies["disc"], backend=backend, mesh=_mesh_spec(mesh))
        variant = replace(scene, bodies={"disc": disc})
        result = _described(run_scene(variant, listener=progress.stage))
        frequencies = np.array([e["im"] for e in result["eigenvalues"]])[:_DISC_MODES] / (2 * np.pi)
        return result | {
            "line": line,
            "backend": backend,
            "mesh": _mesh_words(mesh),
            "frequencies": frequencies.tolist(),
        }

    runs = [run(line, mesh) for line, meshes in DISC_MESHES.items() for mesh in meshes]
    reference = run("reference: NURBS, degree 4, graded to the clamped corners", DISC_REFERENCE)
    for item in runs:
        error = _differences(item, reference)
        item |= {"worst_error": float(error.max()), "median_error": float(np.median(error))}
    return {
        "modes": _DISC_MODES,
        "reference": reference,
        "runs": runs,
        "backend_differences": _backend_differences(runs),
    }


def _differences(run: Mapping[str, Any], other: Mapping[str, Any]) -> NDArray[np.float64]:
    """Relative differences of the frequencies of two runs."""
    return np.abs(np.array(run["frequencies"]) / np.array(other["frequencies"]) - 1)


def _backend_differences(runs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Differences between the graded runs of both backends, mesh by mesh."""
    graded = {b: [r for r in runs if r["backend"] == b and "graded" in r["line"]] for b in BACKENDS}
    return [
        {
            "fe": fe["mesh"],
            "iga": iga["mesh"],
            "worst": float(_differences(fe, iga).max()),
            "median": float(np.median(_differences(fe, iga))),
            "fe_seconds": fe["seconds"],
            "iga_seconds": iga["seconds"],
        }
        for fe, iga in zip(graded["fe"], graded["iga"], strict=True)
    ]


def disc_pad(progress: Progress) -> tuple[dict[str, Any], Sequence[ModesResult]]:
    """Unstable modes of the disc and pad for every formulation on both backends."""
    runs = []
    results: dict[tuple[str, Backend], ModesResult] = {}
    for backend in BACKENDS:
        scene = on_backend(load_scene(Path("disc_pad")), backend)
        bodies: Mapping[str, Body] | None = None
        grid = 10 if backend == "iga" else 4
        for formulation in formulations(backend, grid, (5,)):
            progress.step(f"disc and pad, {backend}, {formulation.method}")
            variant = with_contact(scene, formulation=formulation)
            result = run_modes(variant, bodies=bodies, listener=progress.stage)
            bodies = result.bodies
            run = _described(result)
            runs.append(run | _labels(backend, formulation, run))
            kind = (
                "collocation"
                if isinstance(formulation, NodeToSurface | Greville)
                else (formulation.method)
            )
            results[kind, backend] = result
    agreement = {
        kind: match_unstable(results[kind, "fe"], results[kind, "iga"])
        for kind in ("collocation", "grid", "gpts")
    }
    return {"runs": runs, "agreement": agreement}, list(results.values())


def _labels(backend: Backend, formulation: Formulation, run: Mapping[str, Any]) -> dict[str, Any]:
    points = next(iter(run["contacts"].values()))["points"]
    label = formulation.name
    if isinstance(formulation, GaussPointToSurface):
        label += f" {formulation.points} x {formulation.points}"
    return {
        "backend": backend,
        "method": formulation.method,
        "formulation": label,
        "points": points,
    }


def _mesh_spec(mesh: FeMesh | IgaMesh) -> MeshSpec:
    return MeshSpec(fe=mesh) if isinstance(mesh, FeMesh) else MeshSpec(iga=mesh)


def _mesh_words(mesh: FeMesh | IgaMesh) -> str:
    if isinstance(mesh, FeMesh) and mesh.elements is None:
        return f"size {mesh.size} m"
    assert mesh.elements is not None
    return " x ".join(map(str, mesh.elements))
