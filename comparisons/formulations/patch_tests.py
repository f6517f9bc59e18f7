"""Which formulations pass the contact patch test, and what momentum they lose.

The exact contact pressure of every test is uniform and the exact displacements are linear in each
body, at any P (:mod:`comparisons.formulations.patch_test_problems`): a formulation whose contact
forces are right reproduces them to round-off.
"""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from cea.body import Body
from cea.contact.interface import Interface
from cea.eigen.static import solve_static
from cea.errors import ConvergenceError
from cea.stress import normal_stress
from cea.surface import Surface
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from comparisons.formulations.momentum import momentum_defects, rigid_motions
from comparisons.formulations.patch_test_problems import (
    MESHES,
    PRESSURE,
    PROBLEMS,
    PatchTestProblem,
)
from comparisons.formulations.variants import Variant, variants
from comparisons.kit.progress import Progress
from scenes.build import build_bodies, build_interfaces, build_system
from scenes.read import Scene

PASSED = 1e-6
"""Largest relative error of the normal stress of a patch test that is passed: round-off at the
stiffest, P = 1e14 N/m, stays below it."""

_OWN = 10.0
"""A test is passed too with so many times the error of both bodies under the exact pressure as a
load: on rational geometry quadrature is not exact, theirs nor that of contact forces."""


@dataclass(frozen=True)
class PatchTestStudy:
    """What is run.

    Parameters
    ----------
    stiffnesses
        P (N/m); the blocks and rings themselves have about 1e6.
    gauss
        GPTS points per direction in each cell; lumped and in a full pass too.
    grid_fe, grid_iga
        Equally spaced points per direction over a facet, over a face.
    samples
        Points across a surface where stresses are taken.
    problems
        Names of the interfaces.
    meshes
        Kinds of meshes that sides a and b may have
        (:mod:`comparisons.formulations.patch_test_problems`).
    only
        Labels of formulations (:mod:`comparisons.formulations.variants`); empty takes all.
    """

    stiffnesses: tuple[float, ...] = (1e2, 1e4, 1e6, 1e8, 1e10, 1e12, 1e14)
    gauss: tuple[int, ...] = (5, 25)
    grid_fe: int = 4
    grid_iga: int = 9
    samples: int = 31
    problems: tuple[str, ...] = tuple(problem.name for problem in PROBLEMS)
    meshes: tuple[str, ...] = tuple(MESHES)
    only: tuple[str, ...] = ()

    def variants(self, meshes: tuple[str, str]) -> tuple[Variant, ...]:
        """Formulations between two kinds of meshes."""
        (a, _), (b, _) = (MESHES[kind] for kind in meshes)
        grid = self.grid_iga if a == "iga" else self.grid_fe
        every = variants((a, b), gauss=self.gauss, grid=grid)
        return tuple(v for v in every if not self.only or v.label in self.only)


DEFAULT = PatchTestStudy()


def run_patch_tests(progress: Progress, study: PatchTestStudy = DEFAULT) -> dict[str, Any]:
    """Patch tests and momentum of every formulation.

    Returns
    -------
    dict
        Plain data: ``study``; ``P``; ``passed``, the bound; ``runs`` with ``interface``,
        ``meshes`` of sides a and b, ``formulation``, ``points``, ``errors``, for each P the largest
        of abs(sigma_n + q) / q over both sides (None where the system was singular),
        ``own_error``, the same without contact, ``passes``, the P that passed, and ``momentum``:
        relative defects ``linear`` and ``angular`` of contact forces ``normal`` and ``friction``;
        ``timings`` over all runs.
    """
    timer = StageTimer(progress.stage)
    runs = [
        run
        for problem in PROBLEMS
        if problem.name in study.problems
        for meshes in problem.pairs
        if set(meshes) <= set(study.meshes)
        for run in _runs(progress, timer, study, problem, meshes)
    ]
    return {
        "study": asdict(study),
        "P": list(study.stiffnesses),
        "passed": PASSED,
        "runs": runs,
        "timings": dict(timer.seconds),
    }


def _runs(
    progress: Progress,
    timer: StageTimer,
    study: PatchTestStudy,
    problem: PatchTestProblem,
    meshes: tuple[str, str],
) -> Iterator[dict[str, Any]]:
    scenes = {P: problem.scene(meshes, P) for P in study.stiffnesses}
    bodies: dict[float, Mapping[str, Body]] = {}
    for P, scene in scenes.items():
        # Only where the material depends on P are bodies built anew.
        alike = [bodies[Q] for Q in bodies if scenes[Q].bodies == scene.bodies]
        bodies[P] = alike[0] if alike else build_bodies(scene, timer)
    first, scene = next(iter(scenes.items()))
    sides = scene.contacts["interface"].a, scene.contacts["interface"].b
    own_error = (
        _own_error(problem.alone(meshes, first), sides, study, timer) if problem.held else 0.0
    )
    free = problem.unsupported(meshes, first)
    free_bodies = build_bodies(free, timer)
    motions = {name: rigid_motions(body) for name, body in free_bodies.items()}
    for variant in study.variants(meshes):
        progress.step(f"patch test, {problem.name}, {' on '.join(meshes)}, {variant.label}")
        errors: list[float | None] = []
        searched: tuple[Mapping[str, Body], Mapping[str, Interface]] | None = None
        for P in study.stiffnesses:
            scene = variant.of(scenes[P], P=P)
            if searched is None or searched[0] is not bodies[P]:
                searched = bodies[P], build_interfaces(scene, bodies[P], timer)
            system = build_system(scene, *searched, timer)
            errors.append(_error(system, sides, study.samples, timer))
        interfaces = build_interfaces(variant.of(free, P=first), free_bodies, timer)
        system = build_system(variant.of(free, P=first), free_bodies, interfaces, timer)
        bound = max(PASSED, _OWN * own_error)
        yield {
            "interface": problem.name,
            "meshes": list(meshes),
            "formulation": variant.label,
            "points": sum(len(interface.points) for interface in interfaces.values()),
            "errors": errors,
            "own_error": own_error,
            "passes": [
                P
                for P, error in zip(study.stiffnesses, errors, strict=True)
                if error is not None and error <= bound
            ],
            "momentum": momentum_defects(system, motions),
        }


def _own_error(
    scene: Scene, sides: tuple[str, str], study: PatchTestStudy, timer: StageTimer
) -> float:
    """Error of bodies under the exact pressure as a load, without contact."""
    system = build_system(scene, build_bodies(scene, timer), {}, timer)
    error = _error(system, sides, study.samples, timer)
    assert error is not None, "bodies that need contact to be held"
    return error


def _error(
    system: CoupledSystem, sides: tuple[str, str], samples: int, timer: StageTimer
) -> float | None:
    """Largest relative error of the normal stress on both sides; None when singular."""
    try:
        x = solve_static(system.pencil(), system.load, timer).displacement
    except ConvergenceError:
        return None
    worst = 0.0
    for name, side in (path.split(".") for path in sides):
        body = system.bodies[name]
        surface = body.surfaces[side]
        points = surface.grid(_per_element(surface, samples))
        sigma = normal_stress(surface, points.at, system.displacement(x, name), body.material)
        worst = max(worst, float(np.abs(sigma + PRESSURE).max()) / PRESSURE)
    return worst


def _per_element(surface: Surface, samples: int) -> int:
    return max(3, round(samples / surface.num_elements ** (1 / (surface.dim - 1))))
