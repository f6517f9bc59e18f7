"""What the study runs: contact rules, degrees, meshes and stiffnesses, as scenes."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import prod
from typing import Any

from cea.contact.formulations import (
    Botella,
    GaussPointToSurface,
    Greville,
    Grid,
    Mortar,
    NodeToSurface,
    Segments,
)
from cea.errors import InputError
from comparisons.accuracy.problems import PROBLEMS, BodyMesh, Problem
from comparisons.study.formulations import Variant
from comparisons.study.study import Case
from scenes.spec.body import Backend
from scenes.spec.contact import suits
from scenes.spec.reading import BACKENDS, Scene, load_scene

RULES: Mapping[str, Callable[[int, int], Variant]] = {
    "mortar": lambda gauss, grid: Variant(Mortar()),
    "segments": lambda gauss, grid: Variant(Segments()),
    "GPTS": lambda gauss, grid: Variant(GaussPointToSurface(gauss)),
    "GPTS lumped": lambda gauss, grid: Variant(GaussPointToSurface(gauss, lumped=True)),
    "GPTS full pass": lambda gauss, grid: Variant(GaussPointToSurface(gauss), full_pass=True),
    "grid": lambda gauss, grid: Variant(Grid(grid)),
    "node-to-surface": lambda gauss, grid: Variant(NodeToSurface()),
    "node-to-surface, tributary": lambda gauss, grid: Variant(NodeToSurface("tributary")),
    "Greville": lambda gauss, grid: Variant(Greville()),
    "Greville, area": lambda gauss, grid: Variant(Greville("area")),
    "Botella": lambda gauss, grid: Variant(Botella()),
    "Botella, area": lambda gauss, grid: Variant(Botella("area")),
}
"""Contact rules of given numbers of Gauss and grid points; the yardsticks first."""
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
    thorough
        Whether every contact rule is run at every degree; else mortar at every degree, and every
        rule at degree 2.
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
    thorough: bool = True
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


def methods() -> list[Method]:
    """Every method: each degree of each backend with each contact rule it may have."""
    return [
        Method(backend, degree, rule)
        for rule, variant in RULES.items()
        for backend in BACKENDS
        if suits(variant(2, 2).formulation, backend)
        for degree in DEGREES[backend]
    ]


def lines(options: Options) -> Iterator[Case]:
    """Lines of plots: a problem, a stiffness and a method on finer and finer meshes."""
    first = options.stiffnesses[0]
    for problem in options.problems:
        for p in options.stiffnesses:
            for method in methods():
                also = method.backend == "iga" and method.degree == 3 and options.thorough
                chosen = method.degree == 2 or also
                chosen |= method.rule == "mortar" and (options.thorough or p == first)
                if chosen or (options.thorough and p == first):
                    yield {"problem": problem, "p": p, **vars(method)}


def refinements(case: Case, options: Options) -> list[int]:
    """Refinements of a line, spread over the degrees of freedom allowed; the last off the first p.

    A problem may widen the range of the first stiffness in a thorough study.
    """
    problem, method = PROBLEMS[case["problem"]], method_of(case)
    most = options.most_dofs_2d if problem.dim == 2 else options.most_dofs_3d
    at_first = case["p"] == options.stiffnesses[0]
    if at_first and options.thorough and problem.most_dofs is not None:
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
    return RULES[method.rule](gauss, grid).of(scene, p=problem.unit * p)


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
