"""Contact patch tests on flat, rotated and curved interfaces, between meshes of every kind."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path

from scenes.read import Scene, load_scene
from scenes.spec.body import Backend
from scenes.spec.load import LoadSpec

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
