"""What a study runs: contact rules, methods, meshes and cases, all of them data."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, replace
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
    registered,
)
from comparisons.accuracy.problems import BodyMesh, Problem
from scenes.spec.body import Backend
from scenes.spec.contact_checks import suits
from scenes.spec.scene import BACKENDS


@dataclass(frozen=True)
class ContactRule:
    """A formulation of contact, as a scene names it.

    Parameters
    ----------
    key, label
        Its name in data, and as shown.
    formulation
        Fields of the formulation but its number of points.
    points
        Rule for that number: ``gauss``, one more than the degree; ``grid``, about two for each
        element along an edge; None where there is none to choose.
    full_pass
        Whether both passes are averaged.
    integrates
        Whether it integrates the traces exactly on flat interfaces, so that theory knows its order.
    """

    key: str
    label: str
    formulation: dict[str, Any]
    points: str | None = None
    full_pass: bool = False
    integrates: bool = False

    @property
    def backends(self) -> tuple[Backend, ...]:
        """Backends that side a may have."""
        kind = registered()[self.formulation["method"]]
        return tuple(backend for backend in BACKENDS if suits(kind, backend))


_GPTS = GaussPointToSurface.name

RULES: dict[str, ContactRule] = {
    rule.key: rule
    for rule in (
        ContactRule("mortar", Mortar.name, {"method": "mortar"}, integrates=True),
        ContactRule("segments", Segments.name, {"method": "segments"}, integrates=True),
        ContactRule("gpts", _GPTS, {"method": "gpts"}, "gauss"),
        ContactRule("gpts_lumped", f"{_GPTS} lumped", {"method": "gpts", "lumped": True}, "gauss"),
        ContactRule("full_pass", f"{_GPTS} full pass", {"method": "gpts"}, "gauss", full_pass=True),
        ContactRule("grid", Grid.name, {"method": "grid"}, "grid"),
        *(
            ContactRule(key, formulation.label, asdict(formulation))
            for key, formulation in (
                ("node", NodeToSurface()),
                ("node_tributary", NodeToSurface("tributary")),
                ("greville", Greville()),
                ("greville_area", Greville("area")),
                ("botella", Botella()),
                ("botella_area", Botella("area")),
            )
        ),
    )
}
"""Contact rules by key: the yardsticks first."""

DEGREES: dict[Backend, tuple[int, ...]] = {"fe": (1, 2, 3, 4), "iga": (2, 3, 4, 5, 6)}
"""Degrees of Lagrange elements, and of NURBS at full continuity."""


@dataclass(frozen=True)
class Method:
    """A discretisation of both bodies with a contact rule: a line of a plot."""

    backend: Backend
    degree: int
    rule: str

    @property
    def label(self) -> str:
        """Its name as shown, e.g. "NURBS 3, mortar"."""
        return f"{self.discretisation}, {RULES[self.rule].label}"

    @property
    def discretisation(self) -> str:
        """Its bodies, e.g. "NURBS 3"."""
        return f"{'FE' if self.backend == 'fe' else 'NURBS'} {self.degree}"


@dataclass(frozen=True)
class Case:
    """One point of a plot.

    Parameters
    ----------
    problem
        Name of the problem.
    method
        Discretisation and contact rule.
    refinement
        Elements along each direction, relative to the problem's coarsest mesh.
    stiffness
        Contact stiffness p relative to the problem's unit.
    """

    problem: str
    method: Method
    refinement: int
    stiffness: float

    @property
    def label(self) -> str:
        """The case in words."""
        return (
            f"{self.problem}, {self.method.label}, refinement {self.refinement}, "
            f"p = {self.stiffness:g}"
        )

    def described(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


@dataclass(frozen=True)
class Study:
    """How far a study goes.

    Parameters
    ----------
    stiffnesses
        Contact stiffnesses p relative to the unit of each problem; the first is the one at which
        every degree is run.
    thorough
        Whether every contact rule is run at every degree; else the mortar method at every degree,
        and every rule at degree 2.
    dofs
        Fewest and most degrees of freedom of a case, by dimension.
    levels
        Meshes of a line at most.
    levels_elsewhere
        Of these, how many of the finest are run at other stiffnesses than the first.
    repeats
        Timed runs of a case.
    minutes
        Time for all of it; what is not begun by then is left out, and said.
    case_seconds
        Time for one case with all its runs.
    """

    stiffnesses: tuple[float, ...] = (1.0, 0.1, 10.0, 1000.0)
    thorough: bool = True
    dofs: dict[int, tuple[int, int]] = field(
        default_factory=lambda: {2: (400, 12_000), 3: (500, 4_500)}
    )
    levels: int = 4
    levels_elsewhere: int = 1
    repeats: int = 3
    minutes: float = 55.0
    case_seconds: float = 100.0


FULL = Study()
QUICK = replace(
    FULL,
    thorough=False,
    dofs={2: (400, 4_500), 3: (500, 4_500)},
    levels=2,
    levels_elsewhere=1,
    minutes=4.5,
    case_seconds=30.0,
)

_REFINEMENTS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48)
_COMPARED = {"fe": (2,), "iga": (2, 3)}
"""Degrees at which every contact rule is run at every stiffness."""


def cases(study: Study, problem: Problem) -> list[Case]:
    """Cases of a problem in the order they are run: what matters most, and cheap ones, first."""
    first, *others = study.stiffnesses
    yardstick = {m for m in methods() if m.rule == "mortar"}
    compared = {m for m in methods() if m.degree in _COMPARED[m.backend][: 1 + study.thorough]}
    rounds = [(first, yardstick), (first, compared), *((p, compared) for p in others)]
    if study.thorough:
        rounds += [(first, set(methods())), *((p, yardstick) for p in others)]
    ordered: dict[Case, None] = {}
    for turns in _turns(rounds, first):
        level_cases = [
            (level, Case(problem.name, method, refinement, p))
            for p, chosen in turns
            for method in methods()
            if method in chosen
            for level, refinement in enumerate(
                refinements(study, problem, method)
                if p == first
                else refinements(study, problem, method, wide=False)[-study.levels_elsewhere :]
            )
        ]
        ordered |= dict.fromkeys(case for _, case in sorted(level_cases, key=lambda item: item[0]))
    return list(ordered)


def _turns(
    rounds: list[tuple[float, set[Method]]], first: float
) -> Iterable[list[tuple[float, set[Method]]]]:
    """Rounds one after another, those of other stiffnesses that follow each other as one."""
    together: list[tuple[float, set[Method]]] = []
    for turn in rounds:
        if turn[0] != first:
            together.append(turn)
            continue
        if together:
            yield together
            together = []
        yield [turn]
    if together:
        yield together


def methods() -> list[Method]:
    """Every method: each degree of each backend with each contact rule it may have."""
    return [
        Method(backend, degree, rule.key)
        for rule in RULES.values()
        for backend in rule.backends
        for degree in DEGREES[backend]
    ]


def refinements(study: Study, problem: Problem, method: Method, *, wide: bool = True) -> list[int]:
    """Refinements of a line, spread over the range of dofs that the study allows.

    Wide is the range of the first stiffness, which the problem may widen in a thorough study.
    """
    fewest, most = study.dofs[problem.dim]
    if wide and study.thorough and problem.most_dofs is not None:
        most = problem.most_dofs
    fitting = [n for n in _REFINEMENTS if fewest <= estimated_dofs(problem, method, n) <= most]
    if len(fitting) <= study.levels:
        return fitting
    steps = [round(i * (len(fitting) - 1) / (study.levels - 1)) for i in range(study.levels)]
    return [fitting[i] for i in steps]


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


def overrides(problem: Problem, case: Case) -> list[str]:
    """Fields of the problem's scene that make it the case, as ``path=value``."""
    rule, contact = RULES[case.method.rule], f"contacts.{problem.contact}"
    fields = [
        *(_mesh(problem, body, case) for body in problem.bodies),
        f"{contact}.formulation={_table(rule.formulation | _points(rule, problem, case))}",
        f"{contact}.p={problem.unit * case.stiffness!r}",
        f"{contact}.mu={problem.friction}",
        f"analysis.max_frequency={problem.max_frequency!r}",
    ]
    return [*fields, f"{contact}.full_pass=true"] if rule.full_pass else fields


def _mesh(problem: Problem, body: BodyMesh, case: Case) -> str:
    degree, elements = case.method.degree, list(body.elements(case.refinement))
    if case.method.backend == "fe":
        cell = {2: "quadrilateral", 3: "hexahedron"}[problem.dim]
        mesh = {"cell": cell, "degree": degree, "elements": elements}
        if problem.geometry_degree is not None:
            mesh["geometry_degree"] = problem.geometry_degree
        elif degree == 1 and any(body.closed):
            mesh["geometry_degree"] = 2  # straight facets of both sides would leave gaps
    else:
        mesh = {"degree": [degree] * problem.dim, "elements": elements}
    return f"bodies.{body.name}.mesh.{case.method.backend}={_table(mesh)}"


def _points(rule: ContactRule, problem: Problem, case: Case) -> dict[str, int]:
    if rule.points == "gauss":
        return {"points": case.method.degree + 1}
    if rule.points == "grid":
        if case.method.backend == "fe":
            return {"points": case.method.degree + 2}
        side = problem.bodies[0]  # a closed direction is shared by four faces
        along = zip(side.elements(case.refinement), side.closed, side.in_contact, strict=True)
        return {"points": max(2 * (n // 4 if c else n) + 1 for n, c, used in along if used)}
    return {}


def _table(fields: dict[str, Any]) -> str:
    """Inline table of TOML."""
    text = {True: "true", False: "false"}
    pairs = (
        f"{name} = " + (text[value] if isinstance(value, bool) else f"{value!r}")
        for name, value in fields.items()
    )
    return "{ " + ", ".join(pairs) + " }"
