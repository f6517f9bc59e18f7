"""The main comparison: both scenes on both backends with every formulation, and the disc alone."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cea.body import Body
from cea.formulations import Formulation, GaussPointToSurface, Greville, Grid, NodeToSurface
from cea.timing import StageTimer
from comparisons.build import build_bodies
from comparisons.match import match_unstable
from comparisons.result import describe, machine, versions
from comparisons.run import SceneResult, run_scene
from comparisons.scene import Backend, FeMesh, IgaMesh, MeshSpec, Scene, load_scene

BACKENDS: tuple[Backend, ...] = ("fe", "iga")

EXPECTED_OSCILLATION = {
    ("greville", 25, 1e14): 1722.0,
    ("greville", 25, 1e6): 3233.0,
    ("grid", 81, 1e6): 1678.0,
    ("gpts", 2025, 1e6): 0.446,
    ("gpts", 5625, 1e6): 0.116,
}
"""Oscillation of sigma_n (N/m^2) on the worse side of the NURBS patch test, from an independent
prototype: by formulation, number of points and P (N/m)."""


@dataclass(frozen=True)
class Progress:
    """Where progress is shown: one call as a step begins, one for each stage in it."""

    step: Callable[[str], None]
    stage: Callable[[str], None]


def formulations(backend: Backend, grid: int, gauss: Iterable[int]) -> list[Formulation]:
    """Collocation in the manner of the backend, a grid, and GPTS with several point numbers."""
    collocation = NodeToSurface() if backend == "fe" else Greville()
    return [collocation, Grid(grid), *(GaussPointToSurface(n) for n in gauss)]


def on_backend(scene: Scene, backend: Backend) -> Scene:
    """The scene with every body on one backend."""
    return replace(scene, bodies={n: replace(b, backend=backend) for n, b in scene.bodies.items()})


def with_contact(scene: Scene, **changes: Any) -> Scene:
    """The scene with changed fields of every contact."""
    return replace(scene, contacts={n: replace(c, **changes) for n, c in scene.contacts.items()})


def compare(progress: Progress) -> tuple[dict[str, Any], Mapping[str, SceneResult]]:
    """Run everything.

    Returns
    -------
    dict
        Plain data for ``result.json``.
    dict
        The disc_pad result with GPTS on each backend, for pictures.
    """
    start = perf_counter()
    warm_up(progress)
    data: dict[str, Any] = {"command": "compare", "versions": versions(), "machine": machine()}
    data["patch_test"] = patch_test(progress)
    data["disc_alone"] = disc_alone(progress)
    data["disc_pad"], results = disc_pad(progress)
    data["time_saved"] = time_saved(progress)
    data["seconds"] = perf_counter() - start
    return data, results


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
                run = describe(run_scene(variant, bodies=bodies, listener=progress.stage))
                runs.append(run | _labels(backend, formulation, run) | {"P": P})
    for run in runs:
        sides = run["stresses"]["interface"].values()
        run["oscillation"] = max(side["oscillation"] for side in sides)
        key = (run["method"], run["points"], run["P"])
        run["expected"] = EXPECTED_OSCILLATION.get(key) if run["backend"] == "iga" else None
    return {"exact_sigma_n": -1000.0, "runs": runs}


DISC_MESHES: dict[str, tuple[Backend, list[FeMesh | IgaMesh]]] = {
    "hexahedra, degree 2": (
        "fe",
        [FeMesh("hexahedron", 2, (n, 8 * n, max(1, n // 3))) for n in (3, 5, 8)],
    ),
    "tetrahedra, degree 2": (
        "fe",
        [FeMesh("tetrahedron", 2, size=h) for h in (0.02, 0.012, 0.008)],
    ),
    "NURBS, degree 2": (
        "iga",
        [IgaMesh((2, 2, 2), (n, 8 * n, max(1, n // 3))) for n in (3, 5, 8)],
    ),
    "NURBS, degree 4": ("iga", [IgaMesh((4, 4, 2), (n, 8 * n, 1)) for n in (2, 4, 6)]),
}
"""Meshes of the disc alone: lines of the plot of error against run time."""

_DISC_MODES = 20


def disc_alone(progress: Progress) -> dict[str, Any]:
    """First frequencies of the disc without pad: both backends against one finer reference."""
    scene = load_scene(Path("disc"))

    def run(label: str, backend: Backend, mesh: FeMesh | IgaMesh) -> dict[str, Any]:
        progress.step(f"disc alone, {label}, {_mesh_words(mesh)}")
        disc = replace(scene.bodies["disc"], backend=backend, mesh=_mesh_spec(mesh))
        variant = replace(scene, bodies={"disc": disc})
        result = describe(run_scene(variant, listener=progress.stage))
        frequencies = np.array([e["im"] for e in result["eigenvalues"]])[:_DISC_MODES] / (2 * np.pi)
        return result | {
            "line": label,
            "backend": backend,
            "mesh": _mesh_words(mesh),
            "frequencies": frequencies.tolist(),
        }

    reference = run("reference", "iga", IgaMesh((4, 4, 3), (9, 64, 2)))
    exact = np.array(reference["frequencies"])
    runs = [
        run(label, backend, mesh)
        for label, (backend, meshes) in DISC_MESHES.items()
        for mesh in meshes
    ]
    for item in runs:
        error = np.abs(np.array(item["frequencies"]) / exact - 1)
        item |= {"worst_error": float(error.max()), "median_error": float(np.median(error))}
    return {"modes": _DISC_MODES, "reference": reference, "runs": runs}


def disc_pad(progress: Progress) -> tuple[dict[str, Any], Mapping[str, SceneResult]]:
    """Unstable modes of the disc and pad for every formulation on both backends."""
    runs = []
    results: dict[tuple[str, Backend], SceneResult] = {}
    for backend in BACKENDS:
        scene = on_backend(load_scene(Path("disc_pad")), backend)
        bodies: Mapping[str, Body] | None = None
        grid = 10 if backend == "iga" else 3
        for formulation in formulations(backend, grid, (5,)):
            progress.step(f"disc and pad, {backend}, {formulation.method}")
            variant = with_contact(scene, formulation=formulation)
            result = run_scene(variant, bodies=bodies, listener=progress.stage)
            bodies = result.system.bodies
            run = describe(result)
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
    return {"runs": runs, "agreement": agreement}, {b: results["gpts", b] for b in BACKENDS}


def time_saved(progress: Progress) -> dict[str, Any]:
    """One scene without friction: solved as it is, and as if friction could not be left out."""
    progress.step("disc and pad without friction, with and without what it does not need")
    scene = with_contact(on_backend(load_scene(Path("disc_pad")), "iga"), mu=0.0)
    lean = run_scene(scene, listener=progress.stage)
    full = run_scene(scene, leave_out=False, listener=progress.stage)
    return {
        "scene": "disc_pad, NURBS, mu = 0",
        "skipped": dict(lean.skipped),
        "lean": dict(lean.timer.seconds),
        "full": dict(full.timer.seconds),
        "lean_seconds": lean.timer.total,
        "full_seconds": full.timer.total,
    }


def _labels(backend: Backend, formulation: Formulation, run: Mapping[str, Any]) -> dict[str, Any]:
    points = next(iter(run["contacts"].values()))["points"]
    label = {
        "node_to_surface": "node-to-surface",
        "greville": "Greville",
        "grid": "grid",
        "gpts": "GPTS",
    }[formulation.method]
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
