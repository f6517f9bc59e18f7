"""What the study runs: contact rules, degrees, meshes and stiffnesses, as scenes."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import prod
from typing import Any

from cea.errors import InputError
from comparisons.accuracy.problems import PROBLEMS, BodyMesh, Problem
from comparisons.study.formulations import Variant, variants
from comparisons.study.study import Case
from scenes.spec.body import Backend
from scenes.spec.reading import BACKENDS, Scene, load_scene

YARDSTICKS = ("mortar", "segments", "GPTS")
"""Rules that show the error of the bodies alone, the best first."""
INTEGRATING = ("mortar", "segments")
"""Rules that integrate the traces exactly on flat interfaces: theory knows their order."""
DEGREES: Mapping[Backend, tuple[int, ...]] = {"fe": (1, 2, 3, 4), "iga": (2, 3, 4, 5, 6)}
"""Degrees of Lagrange elements, and of NURBS at full continuity."""
_REFINEMENTS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48)
FEWEST = {2: 400, 3: 500}
"""Fewest degrees of freedom of a case, by dimension."""

PARTS = ("errors", "no flutter")


@dataclass(frozen=True)
class Options:
    """Options of the study.

    Parameters
    ----------
    parts
        Of "errors" (against run time) and "no flutter" (where nothing may grow).
    problems
        Problems with exact eigenvalues.
    stiffnesses
        Contact stiffnesses p in units of each problem; at the first every degree is run.
    most_dofs_2d, most_dofs_3d
        Most degrees of freedom of a run.
    levels
        Meshes of a line at most.
    repeats
        Timed runs of each mesh; medians count.
    """

    parts: tuple[str, ...] = PARTS
    problems: tuple[str, ...] = tuple(PROBLEMS)
    stiffnesses: tuple[float, ...] = (1.0, 0.1, 10.0, 1000.0)
    most_dofs_2d: int = 12_000
    most_dofs_3d: int = 4_500
    levels: int = 4
    repeats: int = 3

    def __post_init__(self) -> None:
        for name, known in (("problems", PROBLEMS), ("parts", PARTS)):
            for value in getattr(self, name):
                if value not in known:
                    raise InputError(name, value, f"one of {', '.join(known)}")


@dataclass(frozen=True)
class Method:
    """A discretisation of both bodies with a contact rule: a line of a plot."""

    backend: Backend
    degree: int
    rule: str


def rules(backend: Backend, gauss: int, grid: int) -> dict[str, Variant]:
    """Contact rules by name, of so many Gauss and grid points; full passes of GPTS alone."""
    every = variants((backend, backend), gauss=(gauss,), grid=grid)
    named = {re.sub(r" \d+", "", variant.label): variant for variant in every}
    return {n: v for n, v in named.items() if not v.full_pass or n.startswith("GPTS")}


def methods() -> list[Method]:
    """Every method: each degree of each backend with each contact rule it may have."""
    return [
        Method(backend, degree, rule)
        for backend in BACKENDS
        for rule in rules(backend, 2, 2)
        for degree in DEGREES[backend]
    ]


def lines(options: Options) -> Iterator[Case]:
    """Lines of plots: a problem, a stiffness and a method on finer and finer meshes.

    At the first stiffness every method is run; at others mortar, and all rules on a few degrees.
    """
    for problem in options.problems:
        for p in options.stiffnesses:
            for method in methods():
                few = (method.backend, method.degree) in (("fe", 2), ("iga", 2), ("iga", 3))
                if p == options.stiffnesses[0] or few or method.rule == "mortar":
                    yield {"problem": problem, "p": p, **vars(method)}


def refinements(case: Case, options: Options) -> list[int]:
    """Refinements of a line, spread over the degrees of freedom allowed; the last off the first p.

    A problem may widen the range of the first stiffness.
    """
    problem, method = PROBLEMS[case["problem"]], method_of(case)
    most = options.most_dofs_2d if problem.dim == 2 else options.most_dofs_3d
    at_first = case["p"] == options.stiffnesses[0]
    if at_first and problem.most_dofs is not None:
        most = problem.most_dofs
    fitting = [
        n for n in _REFINEMENTS if FEWEST[problem.dim] <= estimated_dofs(problem, method, n) <= most
    ]
    if len(fitting) > options.levels:
        steps = (i * (len(fitting) - 1) / (options.levels - 1) for i in range(options.levels))
        fitting = [fitting[round(step)] for step in steps]
    return fitting if at_first else fitting[-1:]


def method_of(case: Case) -> Method:
    """Method of a line."""
    return Method(case["backend"], case["degree"], case["rule"])


def estimated_dofs(problem: Problem, method: Method, refinement: int) -> int:
    """Degrees of freedom of a case, those of supports included."""
    return sum(
        problem.dim
        * prod(
            _functions(method, n, closed)
            for n, closed in zip(body.elements(refinement), body.closed, strict=True)
        )
        for body in problem.bodies
    )


def _functions(method: Method, elements: int, closed: bool) -> int:
    """Basis functions along a direction; four patches make a closed one of NURBS."""
    if method.backend == "fe":
        return method.degree * elements + (not closed)
    return elements + (4 * (method.degree - 1) if closed else method.degree)


def scene_of(
    problem: Problem,
    method: Method,
    refinement: int,
    p: float,
    changes: Mapping[str, Any] | None = None,
) -> Scene:
    """The scene of one point of a plot: p in units of the problem, more changes by their paths."""
    scene = load_scene(problem.name, backend=method.backend).change(
        {
            **(changes or {}),
            **{
                f"bodies.{body.name}.mesh.{method.backend}": _mesh(
                    problem, body, method, refinement
                )
                for body in problem.bodies
            },
            "contacts.interface.mu": problem.friction,
            "analysis.max_frequency": problem.max_frequency,
        }
    )
    gauss, grid = method.degree + 1, _grid_points(problem, method, refinement)
    return rules(method.backend, gauss, grid)[method.rule].of(scene, p=problem.unit * p)


def _mesh(problem: Problem, body: BodyMesh, method: Method, refinement: int) -> dict[str, Any]:
    elements = list(body.elements(refinement))
    if method.backend == "iga":
        return {"degree": [method.degree] * problem.dim, "elements": elements}
    cell = {2: "quadrilateral", 3: "hexahedron"}[problem.dim]
    mesh = {"cell": cell, "degree": method.degree, "elements": elements}
    if problem.geometry_degree is not None:
        mesh["geometry_degree"] = problem.geometry_degree
    elif method.degree == 1 and any(body.closed):
        mesh["geometry_degree"] = 2  # straight facets of both sides would leave gaps
    return mesh


def _grid_points(problem: Problem, method: Method, refinement: int) -> int:
    """Points of a grid: about two for each element along an edge."""
    if method.backend == "fe":
        return method.degree + 2
    side = problem.bodies[0]  # a closed direction is shared by four faces
    along = zip(side.elements(refinement), side.closed, side.in_contact, strict=True)
    return max(2 * (n // 4 if closed else n) + 1 for n, closed, used in along if used)
