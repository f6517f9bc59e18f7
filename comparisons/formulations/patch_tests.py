"""Contact patch tests on flat, rotated and curved interfaces, between meshes of every kind.

The exact contact pressure of every test is uniform and the exact displacements are linear in each
body, at any P: a formulation whose contact forces are right reproduces them to round-off.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from cea.body import Body
from cea.contact.interface import Interface
from cea.eigen.static import solve_static
from cea.errors import ConvergenceError
from cea.surface import Surface
from cea.system.contact_stresses import normal_stress
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from comparisons.formulations.momentum import momentum_defects, rigid_motions
from comparisons.study.columns import Column, wide
from comparisons.study.formulations import Variant, variants
from comparisons.study.numbers import number, shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case
from scenes.building.build import build_bodies, build_interfaces, build_system
from scenes.spec.body import Backend, LoadSpec
from scenes.spec.reading import Scene, load_scene

PRESSURE = 1000.0
"""Exact contact pressure of every patch test (N/m^2)."""

MESHES: dict[str, tuple[Backend, str | None]] = {
    "hexahedra": ("fe", "hexahedron"),
    "tetrahedra": ("fe", "tetrahedron"),
    "quadrilaterals": ("fe", "quadrilateral"),
    "triangles": ("fe", "triangle"),
    "NURBS": ("iga", None),
}
"""Backend and cell of each kind of mesh; all of degree 2."""

_SPACE = ("hexahedra", "tetrahedra")
_PLANE = ("quadrilaterals", "triangles")


def pairs(structured: str, simplices: str) -> tuple[tuple[str, str], ...]:
    """Kinds of meshes of sides a and b: each beside itself, then mixed."""
    alike = [(kind, kind) for kind in (structured, simplices, "NURBS")]
    return (*alike, ("NURBS", structured), (structured, "NURBS"))


@dataclass(frozen=True)
class PatchTestProblem:
    """A contact patch test.

    Parameters
    ----------
    name
        Name of the interface.
    scene_file
        Scene it comes from.
    pairs
        Kinds of meshes of sides a and b.
    overrides
        What is changed in the scene, given P (N/m).
    sizes
        Edge lengths of tetrahedra and triangles of sides a and b (m).
    direction
        Direction of friction on a where momentum is looked at, as in a scene.
    held
        Whether supports hold each body without contact.
    """

    name: str
    scene_file: str
    pairs: tuple[tuple[str, str], ...]
    overrides: Callable[[float], list[str]]
    sizes: tuple[float, float]
    direction: str
    held: bool = False

    def scene(self, meshes: tuple[str, str], P: float, more: Iterable[str] = ()) -> Scene:
        """The scene between two kinds of meshes, with more overrides."""
        overrides = [f"contacts.interface.P={P!r}", *self.overrides(P), *more]
        for body, kind, size in zip(("upper", "lower"), meshes, self.sizes, strict=True):
            backend, cell = MESHES[kind]
            overrides.append(f"bodies.{body}.backend={backend}")
            if cell in ("tetrahedron", "triangle"):
                mesh = f"{{cell='{cell}', degree=2, size={size}}}"
                overrides.append(f"bodies.{body}.mesh.fe={mesh}")
        return load_scene(Path(self.scene_file), overrides)

    def unsupported(self, meshes: tuple[str, str], P: float) -> Scene:
        """The same bodies free of supports, in contact with friction (mu = 1)."""
        return self.scene(
            meshes,
            P,
            [
                "bodies.upper.supports=[]",
                "bodies.lower.supports=[]",
                "contacts.interface.mu=1.0",
                f"contacts.interface.friction_direction_on_a={self.direction}",
            ],
        )

    def alone(self, meshes: tuple[str, str], P: float) -> Scene:
        """Both bodies without contact, the exact contact pressure as a load on each."""
        scene = self.scene(meshes, P)
        contact = scene.contacts["interface"]
        loads = (LoadSpec(contact.a, PRESSURE), LoadSpec(contact.b, PRESSURE))
        return replace(scene, contacts={}, loads=scene.loads + loads)


_ROLLERS = (
    "bodies.upper.supports=[{surface='x_min', components=['normal']},"
    " {surface='y_min', components=['normal']}]"
)
"""Hold body a against everything but motion along the normal, however it is placed."""

_PLACEMENT = "{axis=[1.0, 2.0, -0.5], angle=37.0, translation=[0.3, -0.2, 0.7]}"

_OBLIQUE = "{vector=[1.0, 0.5, 0.3]}"


def _flat(P: float) -> list[str]:
    return [_ROLLERS]


def _rotated(P: float) -> list[str]:
    return [_ROLLERS, *(f"bodies.{body}.placement={_PLACEMENT}" for body in ("upper", "lower"))]


def _curved(P: float) -> list[str]:
    """Young's modulus of the outer ring for which displacements are linear (see the scene)."""
    volumetric = (1 + 0.3) * (1 - 2 * 0.3)
    compliance = volumetric / 1e5 + pi / 2 / P
    return [f"bodies.upper.material={{E={volumetric / compliance!r}, nu=0.3}}"]


PROBLEMS = (
    PatchTestProblem("flat", "patch_test", pairs(*_SPACE), _flat, (3.0, 1.8), _OBLIQUE),
    PatchTestProblem("rotated", "patch_test", pairs(*_SPACE), _rotated, (3.0, 1.8), _OBLIQUE),
    PatchTestProblem(
        "curved",
        "patch_test_curved",
        pairs(*_PLANE),
        _curved,
        (2.4, 1.4),
        "{circumferential_about=[0.0, 0.0, 1.0]}",
        held=True,
    ),
)
"""Every patch test."""

PASSED = 1e-6
"""Largest relative error of the normal stress of a patch test that is passed: round-off at the
stiffest, P = 1e14 N/m, stays below it."""
_OWN = 10.0
"""A test is passed too with so many times the error of both bodies under the exact pressure as a
load: on rational geometry quadrature is not exact, theirs nor that of contact forces."""


@dataclass(frozen=True)
class Options:
    """Options of the patch tests.

    Parameters
    ----------
    P
        Contact stiffnesses (N/m); the blocks and rings themselves have about 1e6.
    gauss
        GPTS points per direction in each cell; lumped and in a full pass too.
    grid_fe, grid_iga
        Equally spaced points per direction over a facet, over a face.
    samples
        Points across a surface where stresses are taken.
    interfaces
        Names of the interfaces.
    meshes
        Kinds of meshes that sides a and b may have.
    formulations
        Labels of formulations; all by default.
    """

    P: tuple[float, ...] = (1e2, 1e4, 1e6, 1e8, 1e10, 1e12, 1e14)
    gauss: tuple[int, ...] = (5, 25)
    grid_fe: int = 4
    grid_iga: int = 9
    samples: int = 31
    interfaces: tuple[str, ...] = tuple(problem.name for problem in PROBLEMS)
    meshes: tuple[str, ...] = tuple(MESHES)
    formulations: tuple[str, ...] = ()


def offered(options: Options, meshes: tuple[str, str]) -> list[Variant]:
    """Formulations between two kinds of meshes."""
    (a, _), (b, _) = (MESHES[kind] for kind in meshes)
    grid = options.grid_iga if a == "iga" else options.grid_fe
    every = variants((a, b), gauss=options.gauss, grid=grid)
    return [v for v in every if not options.formulations or v.label in options.formulations]


def cases(options: Options) -> Iterator[Case]:
    """Every interface between every two kinds of meshes: all formulations share the bodies."""
    for problem in PROBLEMS:
        for a, b in problem.pairs:
            if problem.name in options.interfaces and {a, b} <= set(options.meshes):
                yield {"interface": problem.name, "a": a, "b": b}


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Errors of every formulation at every P, and the momentum that its contact forces lose."""
    options, timer = session.options, StageTimer(session.stage)
    (problem,) = (problem for problem in PROBLEMS if problem.name == case["interface"])
    meshes = case["a"], case["b"]
    scenes = {P: problem.scene(meshes, P) for P in options.P}
    bodies: dict[float, Mapping[str, Body]] = {}
    for P, scene in scenes.items():
        # Only where the material depends on P are bodies built anew.
        alike = [bodies[Q] for Q in bodies if scenes[Q].bodies == scene.bodies]
        bodies[P] = alike[0] if alike else build_bodies(scene, timer)
    first, scene = next(iter(scenes.items()))
    sides = scene.contacts["interface"].a, scene.contacts["interface"].b
    own_error = 0.0
    if problem.held:
        alone = problem.alone(meshes, first)
        system = build_system(alone, build_bodies(alone, timer), {}, timer)
        own_error = _error(system, sides, options.samples, timer) or 0.0
    free = problem.unsupported(meshes, first)
    free_bodies = build_bodies(free, timer)
    motions = {name: rigid_motions(body) for name, body in free_bodies.items()}
    errors, momentum = [], []
    for variant in offered(options, meshes):
        session.stage(variant.label)
        located: tuple[Mapping[str, Body], Mapping[str, Interface]] | None = None
        interfaces = build_interfaces(variant.of(free, P=first), free_bodies, timer)
        points = sum(len(interface.points) for interface in interfaces.values())
        labels = {"formulation": variant.label, "points": points, "own_error": own_error}
        for P in options.P:
            scene = variant.of(scenes[P], P=P)
            if located is None or located[0] is not bodies[P]:
                located = bodies[P], build_interfaces(scene, bodies[P], timer)
            error = _error(build_system(scene, *located, timer), sides, options.samples, timer)
            passed = error is not None and error <= max(PASSED, _OWN * own_error)
            errors.append(labels | {"P": P, "error": error, "passed": passed})
        system = build_system(variant.of(free, P=first), free_bodies, interfaces, timer)
        defects = momentum_defects(system, motions)
        momentum.append(
            {"formulation": variant.label}
            | {f"{part}_{kind}": v for kind, d in defects.items() for part, v in d.items()}
        )
    return {"patch_tests": errors, "momentum": momentum}


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


def runs(result: StudyResult, table: str = "patch_tests") -> pd.DataFrame:
    """Rows of a table, both kinds of meshes in one column."""
    frame = result.frame(table).drop(columns="part", errors="ignore")
    if not frame.empty:
        frame.insert(1, "meshes", frame.pop("a") + " on " + frame.pop("b"))
    return frame


def by_stiffness(result: StudyResult) -> pd.DataFrame:
    """A row for each formulation between two kinds of meshes, a column for each P."""
    index = ["interface", "meshes", "formulation", "points", "own_error"]
    return wide(runs(result), index, "P", "error")


def passes(result: StudyResult, interface: str) -> pd.DataFrame:
    """The P for which each formulation passes on an interface, a column for each two meshes."""
    frame = runs(result)
    if frame.empty:
        return frame
    frame = frame[frame["interface"] == interface]
    rows = [
        {"formulation": formulation, "meshes": meshes, "passes": _passed(own)}
        for (formulation, meshes), own in frame.groupby(["formulation", "meshes"], sort=False)
    ]
    return wide(pd.DataFrame(rows), ["formulation"], "meshes", "passes")


def _passed(own: pd.DataFrame) -> str:
    """The P of a test that is passed, in words."""
    passed = own.loc[own["passed"], "P"].tolist()
    if len(passed) in (0, len(own)):
        return "every" if passed else "none"
    if len(passed) > 1 and passed == own["P"].tolist()[-len(passed) :]:
        return f"{number(passed[0], 1)} and more"
    return ", ".join(number(P, 1) for P in passed)


def momentum(result: StudyResult) -> pd.DataFrame:
    """Largest loss of momentum of each formulation on each interface, over all meshes."""
    frame = runs(result, "momentum")
    if frame.empty:
        return frame
    keys = ["interface", "formulation"]
    return frame.drop(columns="meshes").groupby(keys, sort=False).max().reset_index()


def headline(result: StudyResult) -> str | None:
    """Which formulations pass on every interface but the curved one, at every P."""
    frame = runs(result)
    if frame.empty:
        return None
    flat = frame[frame["interface"] != "curved"].groupby("formulation", sort=False)["passed"].all()
    return f"Pass on flat interfaces at every P: {', '.join(flat[flat].index) or 'none'}."


def lines(result: StudyResult) -> pd.DataFrame:
    """Errors over P, a panel for each two kinds of meshes."""
    frame = runs(result)
    if not frame.empty:
        frame["panel"] = frame["interface"] + ", " + frame["meshes"]
    return frame


OWN = {
    "meshes": Column("a on b"),
    "own_error": Column("own", show=shown(1)),
    "error": Column("relative error of σₙ", show=shown(1)),
}
MOMENTUM = {
    f"{part}_{kind}": Column(f"{part}, {kind}", show=shown(1))
    for part in ("linear", "angular")
    for kind in ("normal", "friction")
}
SECTIONS = [
    Section(
        "Patch tests",
        f"Largest error of σₙ relative to the exact pressure, over both sides. Passed is below "
        f"{number(PASSED, 1)}, or of the size of the error that both bodies have without contact "
        "(“own”).",
        headline,
        [
            *(
                Table(
                    f"passes_{problem.name}",
                    f"Interface: {problem.name}. P (N/m) for which each formulation passes.",
                    lambda result, name=problem.name: passes(result, name),  # type: ignore[misc]
                )
                for problem in PROBLEMS
            ),
            Table("patch_tests", "Errors for each P (N/m).", by_stiffness, OWN, "interface"),
        ],
        [
            Plot(
                *("patch_errors", "Error of every formulation over P.", lines, "P", "error"),
                *(("formulation",), "panel", "xy", OWN),
            )
        ],
    ),
    Section(
        "Momentum",
        "Resultant force (linear) and moment (angular) of contact forces on both bodies together, "
        "relative to the largest that they could have. Where meshes of a curved interface leave "
        "gaps, friction has a moment.",
        tables=[Table("momentum", "The largest over all meshes.", momentum, MOMENTUM, "interface")],
    ),
]
