"""Contact patch tests between all kinds of meshes.

In every test the exact contact pressure is uniform and the exact displacements are linear in each
body, at any P: a formulation with correct contact forces reproduces them to round-off.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd

from cea.errors import ConvergenceError
from cea.system.contact_stresses import normal_stress
from comparisons.study.columns import wide
from comparisons.study.formulations import Variant, variants
from comparisons.study.numbers import number, shown
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.study import Case, Session, Study, StudyResult
from scenes import Result
from scenes.spec.body import Backend, LoadSpec
from scenes.spec.reading import Scene, load_scene

PRESSURE = 1000.0  # exact contact pressure of every patch test (N/m^2)
PASSED = 1e-6
"""Largest relative error of the normal stress of a passed test. Round-off at the stiffest contact,
P = 1e14 N/m, is smaller."""
_OWN = 10.0
"""Factor on the error of both bodies without contact, loaded by the exact pressure, up to which a
test is passed too: on rational geometry quadrature is not exact."""
MESHES: dict[str, tuple[Backend, str | None]] = {
    "hexahedra": ("fe", "hexahedron"),
    "tetrahedra": ("fe", "tetrahedron"),
    "quadrilaterals": ("fe", "quadrilateral"),
    "triangles": ("fe", "triangle"),
    "NURBS": ("iga", None),
}
"""Backend and cell of each kind of mesh; all of degree 2."""
_GRIDS: dict[Backend, int] = {"fe": 4, "iga": 9}  # points per direction over a facet, over a face
_PLACEMENT = "{axis=[1.0, 2.0, -0.5], angle=37.0, translation=[0.3, -0.2, 0.7]}"
_ROLLERS = (
    "bodies.upper.supports=[{surface='x_min', components=['normal']},"
    " {surface='y_min', components=['normal']}]"
)
"""Supports that leave body a only its motion along the contact normal, in any placement."""


@dataclass(frozen=True)
class PatchTestProblem:
    """A contact patch test; the name is that of its interface."""

    name: str
    scene_file: str
    kinds: tuple[str, str]  # kinds of Lagrange meshes: structured, simplices
    overrides: Callable[[float], list[str]]  # changes of the scene for a P (N/m)
    sizes: tuple[float, float]  # edge lengths of tetrahedra and triangles of sides a and b (m)
    held: bool = False  # whether each body is supported without contact

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Kinds of meshes of sides a and b: equal kinds, then NURBS with Lagrange elements."""
        alike = [(kind, kind) for kind in (*self.kinds, "NURBS")]
        return (*alike, ("NURBS", self.kinds[0]), (self.kinds[0], "NURBS"))

    def scene(self, meshes: tuple[str, str], P: float, more: Iterable[str] = ()) -> Scene:
        """Return the scene with two kinds of meshes and more overrides."""
        overrides = [f"contacts.interface.P={P!r}", *self.overrides(P), *more]
        for body, kind, size in zip(("upper", "lower"), meshes, self.sizes, strict=True):
            backend, cell = MESHES[kind]
            overrides.append(f"bodies.{body}.backend={backend}")
            if cell in ("tetrahedron", "triangle"):
                mesh = f"{{cell='{cell}', degree=2, size={size}}}"
                overrides.append(f"bodies.{body}.mesh.fe={mesh}")
        return load_scene(Path(self.scene_file), overrides)

    def alone(self, meshes: tuple[str, str], P: float) -> Scene:
        """Return both bodies without contact, each loaded by the exact contact pressure."""
        scene = self.scene(meshes, P)
        contact = scene.contacts["interface"]
        loads = (LoadSpec(contact.a, PRESSURE), LoadSpec(contact.b, PRESSURE))
        return replace(scene, contacts={}, loads=scene.loads + loads)


def _rotated(P: float) -> list[str]:
    return [_ROLLERS, *(f"bodies.{body}.placement={_PLACEMENT}" for body in ("upper", "lower"))]


def _curved(P: float) -> list[str]:
    """Set Young's modulus of the outer ring so that displacements are linear (see the scene)."""
    volumetric = (1 + 0.3) * (1 - 2 * 0.3)
    compliance = volumetric / 1e5 + pi / 2 / P
    return [f"bodies.upper.material={{E={volumetric / compliance!r}, nu=0.3}}"]


_FLAT = PatchTestProblem(
    "flat",
    "patch_test",
    ("hexahedra", "tetrahedra"),
    lambda P: [_ROLLERS],
    (3.0, 1.8),
)
PROBLEMS = (
    _FLAT,
    replace(_FLAT, name="rotated", overrides=_rotated),
    PatchTestProblem(
        "curved",
        "patch_test_curved",
        ("quadrilaterals", "triangles"),
        _curved,
        (2.4, 1.4),
        held=True,
    ),
)
"""Every patch test."""
_STIFFNESSES = (1e2, 1e4, 1e6, 1e8, 1e10, 1e12, 1e14)


@dataclass(frozen=True)
class Options:
    """Options of the study."""

    # the blocks and rings have a stiffness of about 1e6 N/m
    P: Annotated[tuple[float, ...], "Contact stiffnesses (N/m)."] = _STIFFNESSES
    gauss: Annotated[tuple[int, ...], "GPTS points per direction in each cell."] = (5, 25)
    samples: Annotated[int, "Points across a surface at which stresses are evaluated."] = 31
    interfaces: Annotated[tuple[str, ...], "Names of the interfaces."] = (
        "flat",
        "rotated",
        "curved",
    )
    meshes: Annotated[tuple[str, ...], "Kinds of meshes of the two sides."] = tuple(MESHES)
    formulations: Annotated[tuple[str, ...], "Labels of formulations; default: all."] = ()


def offered(options: Options, meshes: tuple[str, str]) -> dict[str, Variant]:
    """Return the formulations by label for two kinds of meshes."""
    (a, _), (b, _) = (MESHES[kind] for kind in meshes)
    return variants((a, b), options.gauss, _GRIDS[a], options.formulations)


def cases(options: Options) -> Iterator[Case]:
    """Every interface with every pair of kinds of meshes; all formulations share the bodies."""
    for problem in PROBLEMS:
        for a, b in problem.pairs:
            if problem.name in options.interfaces and {a, b} <= set(options.meshes):
                yield {"interface": problem.name, "a": a, "b": b}


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Return errors of every formulation at every P."""
    options, meshes = session.options, (case["a"], case["b"])
    (problem,) = (problem for problem in PROBLEMS if problem.name == case["interface"])
    scenes = {P: problem.scene(meshes, P, ["analysis.samples=2"]) for P in options.P}
    own_error, errors = 0.0, list[dict[str, Any]]()
    if problem.held:
        alone = session.solve(problem.alone(meshes, options.P[0]))
        own_error = error_of(alone, scenes[options.P[0]], options.samples)
    for label, variant in offered(options, meshes).items():
        points = 0
        for P, scene in scenes.items():
            error: float | None = None
            try:
                result = session.solve(variant.of(scene, P=P))
                points = sum(len(each.points) for each in result.interfaces.values())
                error = error_of(result, scene, options.samples)
            except ConvergenceError:
                pass  # singular matrix
            passed = error is not None and error <= max(PASSED, _OWN * own_error)
            row = {"formulation": label, "points": points, "own_error": own_error}
            errors.append(row | {"P": P, "error": error, "passed": passed})
    return {"patch_tests": errors}


def error_of(result: Result, scene: Scene, samples: int) -> float:
    """Return the largest relative error of the normal stress over both sides of the contact."""
    contact, worst, system = scene.contacts["interface"], 0.0, result.system
    for name, side in (path.split(".") for path in (contact.a, contact.b)):
        surface, u = system.bodies[name].surfaces[side], system.displacement(result.solution, name)
        along = round(samples / surface.num_elements ** (1 / (surface.dim - 1)))
        at = surface.grid(max(3, along)).at
        sigma = normal_stress(surface, at, u, system.bodies[name].material)
        worst = max(worst, float(np.abs(sigma + PRESSURE).max()) / PRESSURE)
    return worst


def runs(result: StudyResult) -> pd.DataFrame:
    """Every run, with both kinds of meshes in one column."""
    frame = result.frame("patch_tests")
    frame.insert(1, "meshes", frame.pop("a") + " on " + frame.pop("b"))
    return frame


def by_stiffness(result: StudyResult) -> pd.DataFrame:
    """A row for each formulation and pair of meshes, a column for each P."""
    index = ["interface", "meshes", "formulation", "points", "own_error"]
    return wide(runs(result), index, "P", "error")


def headline(result: StudyResult) -> str:
    """Name the formulations that pass on every flat interface at every P."""
    frame = runs(result).query("interface != 'curved'")
    flat = frame.groupby("formulation", sort=False)["passed"].all()
    return f"Pass on flat interfaces at every P: {', '.join(flat[flat].index) or 'none'}."


OWN: Mapping[str, Column] = {
    "meshes": Column("a on b"),
    "own_error": Column("own", show=shown(1)),
    "error": Column("relative error of σₙ", show=shown(1)),
}
SECTIONS = [
    Section(
        "Patch tests",
        "Largest error of σₙ relative to the exact pressure, over both sides. Passed: below "
        f"{number(PASSED, 1)}, or below {_OWN:g} times the error of both bodies without contact "
        "(“own”).",
        headline,
        [Table("patch_tests", "Errors for each P (N/m).", by_stiffness, OWN)],
        [
            Plot(
                "patch_errors",
                "Error of every formulation against P.",
                runs,
                "P",
                "error",
                ("formulation",),
                ("interface", "meshes"),
                "xy",
                OWN,
            )
        ],
        of="patch_tests",
    ),
]
STUDY = Study(
    name="patch_tests",
    title="Patch tests of contact formulations",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    quick={
        "P": (1e6, 1e14),
        "gauss": (5,),
        "samples": 9,
        "interfaces": ("flat",),
        "meshes": ("NURBS",),
        "formulations": ("Greville", "GPTS 5", "GPTS 5, lumped", "segments", "mortar"),
    },
    sections=SECTIONS,
)
