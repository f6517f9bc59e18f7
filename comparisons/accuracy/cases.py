"""Cases of the study: contact rules, degrees, meshes and stiffnesses, as scenes."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import prod
from typing import Annotated, Any

import numpy as np

from cea.errors import require
from comparisons.accuracy.problems import PROBLEMS, Problem
from comparisons.study.formulations import Variant, variants
from comparisons.study.study import Case
from scenes.spec.body import Backend
from scenes.spec.reading import BACKENDS, Scene, load_scene

YARDSTICKS = ("mortar", "segments")
"""Reference rules, exact on flat interfaces: their error is that of the bodies' meshes alone, and
their order of convergence is known."""
DEGREES: Mapping[Backend, tuple[int, ...]] = {"fe": (1, 2, 3, 4), "iga": (2, 3, 4, 5, 6)}
"""Degrees of Lagrange elements, and of NURBS at full continuity."""
_REFINEMENTS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48)  # factors on the coarsest mesh
FEWEST = {2: 400, 3: 500}  # fewest degrees of freedom of a case, by dimension


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
    given = {"contacts.interface.mu": problem.friction}
    given["analysis.max_frequency"] = problem.max_frequency
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
