"""Cases of the study: contact rules, degrees, meshes and stiffnesses; errors and run times."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from math import prod, tau
from typing import Annotated, Any

import numpy as np

from cea.arrays import Complexes
from cea.errors import ConvergenceError, InputError, require
from comparisons.accuracy.problems import PROBLEMS, Problem, exact
from comparisons.study.formulations import Variant, variants
from comparisons.study.matching import match_spectrum
from comparisons.study.measure import measured
from comparisons.study.study import Case, Session
from scenes import run_modes
from scenes.spec.body import Backend
from scenes.spec.reading import BACKENDS, Scene, load_scene

YARDSTICKS = ("mortar", "segments")
"""Reference rules, exact on flat interfaces: their error is that of the bodies' meshes alone."""
DEGREES: Mapping[Backend, tuple[int, ...]] = {"fe": (1, 2, 3, 4), "iga": (2, 3, 4, 5, 6)}
"""Degrees of Lagrange elements, and of NURBS at full continuity."""
_REFINEMENTS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48)  # factors on the coarsest mesh
FEWEST = {2: 400, 3: 500}  # fewest degrees of freedom of a case, by dimension
_BEYOND = 1.1  # end of the search over that of the band: modes at the end keep partners
_REACH = 0.25  # largest relative distance of a computed eigenvalue from the exact one it matches
_DIGITS = 4  # significant digits stored of run times, memory and errors


@dataclass(frozen=True)
class Options:
    """Options of the study."""

    problems: Annotated[tuple[str, ...], "Problems with exact eigenvalues."] = tuple(PROBLEMS)
    stiffnesses: Annotated[
        tuple[float, ...],
        "Contact stiffnesses p in units of each problem; all degrees at the first.",
    ] = (1.0, 0.1, 10.0, 1000.0)
    most_dofs_2d: Annotated[int, "Most degrees of freedom of a run in the plane."] = 12_000
    most_dofs_3d: Annotated[int, "Most degrees of freedom of a run in space."] = 4_500
    levels: Annotated[int, "Largest number of meshes of a line."] = 4
    repeats: Annotated[int, "Timed runs of each mesh; the median is reported."] = 3

    def __post_init__(self) -> None:
        for value in self.problems:
            require(value in PROBLEMS, "problems", value, f"one of {', '.join(PROBLEMS)}")


def rules(backend: Backend, gauss: int, grid: int) -> dict[str, Variant]:
    """Return contact rules by name, with these Gauss and grid points; full pass for GPTS only."""
    every = variants((backend, backend), (gauss,), grid)
    named = {re.sub(r" \d+", "", label): variant for label, variant in every.items()}
    return {n: v for n, v in named.items() if not v.full_pass or n.startswith("GPTS")}


def methods() -> list[dict[str, Any]]:
    """Return every discretisation of both bodies with every contact rule it supports."""
    return [
        {"backend": backend, "degree": degree, "rule": rule}
        for backend in BACKENDS
        for rule in rules(backend, 2, 2)
        for degree in DEGREES[backend]
    ]


def cases(options: Options) -> Iterator[Case]:
    """Lines of plots: all methods at the first stiffness; else mortar or low degrees."""
    for problem in options.problems:
        for p in options.stiffnesses:
            for method in methods():
                few = (method["backend"], method["degree"]) in (("fe", 2), ("iga", 2), ("iga", 3))
                if p == options.stiffnesses[0] or few or method["rule"] == "mortar":
                    yield {"problem": problem, "p": p, **method}


def refinements(case: Case, options: Options) -> list[int]:
    """Refinements of a line, spread over the dofs allowed; the last one at other stiffnesses."""
    problem, at_first = PROBLEMS[case["problem"]], case["p"] == options.stiffnesses[0]
    most = options.most_dofs_2d if problem.dim == 2 else options.most_dofs_3d
    if at_first and problem.most_dofs is not None:
        most = problem.most_dofs
    fewest = FEWEST[problem.dim]
    fitting = [n for n in _REFINEMENTS if fewest <= estimated_dofs(problem, case, n) <= most]
    if len(fitting) > options.levels:
        steps = np.linspace(0, len(fitting) - 1, options.levels).round().astype(int)
        fitting = [fitting[step] for step in steps]
    return fitting if at_first else fitting[-1:]


def estimated_dofs(problem: Problem, case: Case, refinement: int) -> int:
    """Return the dofs of a mesh, including those of supports; a ring has four patches."""
    degree = case["degree"]

    def functions(direction: int, coarsest: int) -> int:
        elements, closed = refinement * coarsest, direction == problem.closed
        if case["backend"] == "fe":
            return degree * elements + (not closed)
        return elements + (4 * (degree - 1) if closed else degree)

    return problem.dim * sum(
        prod(functions(*each) for each in enumerate(coarsest))
        for coarsest in problem.bodies.values()
    )


def scene_of(problem: Problem, case: Case, refinement: int) -> Scene:
    """Return the scene of one point of a plot, with p in units of the problem."""
    backend, degree, closed = case["backend"], case["degree"], problem.closed is not None
    if backend == "iga":
        common: dict[str, Any] = {"degree": [degree] * problem.dim}
    else:
        cell = {2: "quadrilateral", 3: "hexahedron"}[problem.dim]
        common = {"cell": cell, "degree": degree, "geometry_degree": problem.geometry_degree}
        if degree == 1 and closed and problem.geometry_degree is None:
            common["geometry_degree"] = 2  # straight facets of both sides would leave gaps
    meshes = {
        f"bodies.{body}.mesh.{backend}": common | {"elements": [refinement * n for n in coarsest]}
        for body, coarsest in problem.bodies.items()
    }
    given: dict[str, Any] = {"analysis.max_frequency": _BEYOND * problem.band[1] / tau}
    profile = problem.profile
    given["contacts.interface.mu"] = f"{problem.mu}{profile}" if profile else problem.mu
    scene = load_scene(problem.name, backend=backend).change(meshes | given)
    grid = degree + 2  # about two points for each element along an edge
    if backend == "iga":  # a closed direction has four patches
        first = next(iter(problem.bodies.values()))
        along = {
            d: refinement * first[d] // (4 if d == problem.closed else 1)
            for d in problem.in_contact
        }
        grid = 2 * max(along.values()) + 1
    return rules(backend, degree + 1, grid)[case["rule"]].of(scene, p=problem.unit * case["p"])


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Return the runs of a line, which ends at the first failure, and the reason for it."""
    runs, omissions = list[dict[str, Any]](), list[dict[str, Any]]()
    for refinement in refinements(case, session.options):
        try:
            runs.append(measure(case, refinement, session.options.repeats))
        except (ConvergenceError, InputError) as failure:
            omissions.append({"refinement": refinement, "reason": str(failure)})
            break
    return {"runs": runs, "omissions": omissions}


def measure(case: Case, refinement: int, repeats: int) -> dict[str, Any]:
    """Return processor time (s, medians), peak memory (MB) and errors of one mesh."""
    problem, taken, memory = PROBLEMS[case["problem"]], [], []
    _warm_up(case["problem"], case["backend"], case["degree"], case["rule"])
    scene = scene_of(problem, case, refinement)
    for _ in range(repeats):
        with measured() as cost:
            result = run_modes(scene)
        taken.append(result.timer.processor_seconds)
        memory.append(cost.memory)
    row: dict[str, Any] = {
        "dofs": result.system.size,
        "points": len(next(iter(result.interfaces.values())).points),
        "seconds": float(np.median([sum(stages.values()) for stages in taken])),
        **{stage: float(np.median([each[stage] for each in taken])) for stage in taken[0]},
        "memory": memory[0],
    }
    row |= errors(result.eigenvalues, exact(case["problem"], case["p"]), problem.band)
    return {"refinement": refinement} | {
        name: float(f"{v:.{_DIGITS}g}") if isinstance(v, float) else v for name, v in row.items()
    }


@cache
def _warm_up(problem: str, backend: str, degree: int, rule: str) -> None:
    """Run the coarsest mesh once in a process, which compiles forms and fills caches."""
    case = {"p": 1.0, "backend": backend, "degree": degree, "rule": rule}
    run_modes(scene_of(PROBLEMS[problem], case, 1))


def errors(computed: Complexes, right: Complexes, band: tuple[float, float]) -> dict[str, Any]:
    """Return errors over the exact eigenvalues of a band (None if any is missing), and counts."""
    match = match_spectrum(computed, right, band, reach=_REACH)
    found: dict[str, Any] = {"modes": len(match.exact)}
    for name, error in (
        ("lambda", match.errors),
        ("frequency", match.frequency_errors),
        ("growth", match.growth_errors),
    ):
        values = {"worst": error.max(initial=0.0), "median": np.median(error) if len(error) else 0}
        for which, value in values.items():
            found[f"{name}_{which}"] = float(value) if np.isfinite(value) else None
    return found | {"missing": len(match.missing), "spurious": len(match.spurious)}
