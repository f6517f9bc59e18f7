"""What a scene says of a body: supports, damping, loads, and all else it is made of."""

from dataclasses import dataclass, field
from math import pi
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag

from cea.errors import require
from cea.material import AnisotropicMaterial, IsotropicMaterial, OrthotropicMaterial
from cea.motion import ModalDamping, RayleighDamping, Rotation
from cea.supports.boundary import Spring, Support
from meshes.mesh_file import MeshFile
from meshes.patches import NurbsFile, Patches
from meshes.placement import Placement
from meshes.shapes import Shape, VentilatedDisc
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec

Backend = Literal["fe", "iga"]


def kind(given: Any) -> Any:
    """Kind of a material, by which messages call the field that says it."""
    if isinstance(given, dict):
        return given.get("kind", "isotropic")
    return getattr(given, "kind", "isotropic")


def _without_kind(given: Any) -> Any:
    """An isotropic material as scenes have it, without its kind."""
    return {k: v for k, v in given.items() if k != "kind"} if isinstance(given, dict) else given


Material = Annotated[
    Annotated[IsotropicMaterial, BeforeValidator(_without_kind), Tag("isotropic")]
    | Annotated[OrthotropicMaterial, Tag("orthotropic")]
    | Annotated[AnisotropicMaterial, Tag("anisotropic")],
    Discriminator(kind),
]


BACKEND_NAMES = {"fe": "finite elements", "iga": "NURBS"}
"""Backends by the name shown."""


def backend_name(backend: str) -> str:
    """Name of a backend as shown; "fe+iga" where bodies of both touch."""
    return " and ".join(BACKEND_NAMES.get(part, part) for part in backend.split("+"))


def file_name(name: str) -> str:
    """Name of a scene as files bear it: signs but letters, digits, _ and - become _."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)


@dataclass(frozen=True)
class DampingSpec:
    """Damping of a body: Rayleigh damping C = alpha M + beta K, modal damping, or both.

    The former is given by its factors, or by damping ratios.

    Parameters
    ----------
    alpha
        Factor on the mass (1/s).
    beta
        Factor on the stiffness (s).
    ratios
        Damping ratios at two frequencies, given instead; 1 is critical.
    frequencies
        These frequencies (Hz).
    modal
        Damping ratios of the modes of the body alone.
    """

    alpha: float | None = None
    beta: float | None = None
    ratios: tuple[float, float] | None = None
    frequencies: tuple[float, float] | None = None
    modal: ModalDamping | None = None

    def __post_init__(self) -> None:
        ways = [self.alpha is not None or self.beta is not None, self.ratios is not None]
        allowed = "alpha, beta or both; or ratios with frequencies; modal, or it beside these"
        one_way = any(ways) or self.modal is not None
        require(one_way and not all(ways), "ratios", self.ratios, allowed)
        both = (self.ratios is None) == (self.frequencies is None)
        require(both, "frequencies", self.frequencies, "two where ratios are given")
        self.rayleigh()

    @property
    def acts(self) -> bool:
        """Whether anything is damped."""
        modal = self.modal is not None and self.modal.acts
        return modal or self.rayleigh() not in (None, RayleighDamping())

    @property
    def in_factors(self) -> "DampingSpec":
        """The same with factors of Rayleigh damping in the place of ratios, both where one is."""
        found = self.rayleigh()
        return self if found is None else DampingSpec(found.alpha, found.beta, modal=self.modal)

    def rayleigh(self) -> RayleighDamping | None:
        """Rayleigh damping as the system takes it; None where there is modal damping alone."""
        if self.ratios is not None and self.frequencies is not None:
            return RayleighDamping.of_ratios(self.ratios, self.frequencies)
        if self.alpha is None and self.beta is None:
            return None
        return RayleighDamping(self.alpha or 0.0, self.beta or 0.0)


class Face(NamedTuple):
    """A face across a direction, at its end 0 or 1, and the coordinate that it lies at."""

    direction: str
    end: int
    at: float


_FACES = {
    "x": (("x_min",), ("x_max",)),
    "y": (("y_min",), ("y_max",)),
    "z": (("z_min", "bottom", "hub_bottom"), ("z_max", "top", "hub_top")),
    "r": (("inner", "bore"), ("outer",)),
    "theta": (("start",), ("end",)),
}
"""Surfaces at both ends of a direction."""


@dataclass(frozen=True)
class BodySpec:
    """A body: backend, geometry, meshes, material, supports, damping, rotation.

    Parameters
    ----------
    backend
        ``fe``, Lagrange elements, or ``iga``, NURBS.
    geometry
        Its shape, in coordinates of its own.
    material
        Linear elasticity, isotropic if no ``kind`` is given.
    mesh
        How it is divided, for each backend that it is to be run on.
    supports
        Displacements that are held.
    springs
        Elastic foundations of surfaces.
    placement
        Where the shape stands in space.
    damping
        Rayleigh and modal damping.
    rotation
        Steady rotation about its own axis, seen from the frame at rest.
    """

    backend: Backend
    geometry: Annotated[Shape, Field(discriminator="shape")]
    material: Material
    mesh: MeshSpec = field(default_factory=MeshSpec)
    supports: tuple[Support, ...] = ()
    springs: tuple[Spring, ...] = ()
    placement: Placement = field(default_factory=Placement)
    damping: DampingSpec | None = None
    rotation: Rotation | None = None

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return len(self.geometry.directions)

    @property
    def faces(self) -> dict[str, Face]:
        """Faces of its shape across its directions, by the names of their surfaces."""
        shape, found = self.geometry, {}
        for direction, ends in zip(shape.directions, shape.extent, strict=True):
            for end, names in enumerate(_FACES.get(direction, ())):
                for name in names:
                    at = getattr(shape, name, ends[end]) if direction == "z" else ends[end]
                    found[name] = Face(direction, end, float(at))
        return {name: face for name, face in found.items() if name in shape.surfaces}

    @property
    def circulates(self) -> bool:
        """Whether damping is carried along by a rotation."""
        return self.rotation is not None and self.damping is not None

    @property
    def rotates_in_equilibrium(self) -> bool:
        """Whether forces of a rotation act on displacements that are at rest in space."""
        convective = self.rotation is not None and self.rotation.convective_stiffness
        return convective or self.circulates

    @property
    def lengths(self) -> list[float]:
        """Lengths (m) of a box that stands for its shape: of an arc, at its middle radius."""
        shape = self.geometry
        if isinstance(shape, VentilatedDisc):
            return list(shape.lengths)
        if isinstance(shape, Patches | NurbsFile):
            given = shape.given if isinstance(shape, NurbsFile) else shape
            points = np.concatenate([p.points.reshape(-1, len(p.degrees)) for p in given.patches])
            return np.ptp(points, axis=0).tolist()
        found = [high - low for low, high in shape.extent]
        if "theta" in shape.directions:
            found[shape.directions.index("theta")] *= pi / 180 * 0.5 * sum(shape.extent[0])
        return found

    @property
    def division(self) -> FeMesh | IgaMesh | None:
        """Its mesh on its backend; None of a mesh file."""
        return self.mesh.fe if self.backend == "fe" else self.mesh.iga

    @property
    def degree(self) -> int:
        """Lowest degree of its elements."""
        mesh = self.division
        return min(mesh.degree) if isinstance(mesh, IgaMesh) else self.fe_degree or 0

    @property
    def smooth(self) -> bool:
        """Whether its elements are splines of some continuity."""
        mesh = self.division
        return isinstance(mesh, IgaMesh) and min(mesh.continuities) > 0

    @property
    def fe_degree(self) -> int | None:
        """Degree of its Lagrange elements; None where it has none."""
        if isinstance(self.geometry, MeshFile):
            elements = self.geometry.elements
            least = 2 if elements.is_divided else 1  # straight tetrahedra are too stiff
            return self.mesh.degree or max(elements.order, least)
        return self.mesh.fe.degree if self.mesh.fe is not None else None


@dataclass(frozen=True)
class LoadSpec:
    """A load: a pressure or a force on a surface, or a force on every part of a body.

    Parameters
    ----------
    surface
        The surface "body.surface".
    pressure
        Uniform pressure on it (N/m^2), positive pushes on the body.
    force
        Components of a force (N; N/m in the plane) that is spread evenly over it.
    body
        The body, given instead of a surface.
    body_force
        Components of a force for each volume of it (N/m^3).
    """

    surface: str | None = None
    pressure: float | None = None
    force: tuple[float, ...] | None = None
    body: str | None = None
    body_force: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        one_place = (self.surface is None) != (self.body is None)
        require(one_place, "surface", self.surface, f"either surface or body ({self.body})")
        if self.body is None:
            allowed = "left out on a surface"
            require(self.body_force is None, "body_force", self.body_force, allowed)
            one = (self.pressure is None) != (self.force is None)
            allowed = "either pressure or force, not both, on a surface"
            require(one, "pressure", self.pressure, allowed)
        else:
            for name, value in (("pressure", self.pressure), ("force", self.force)):
                require(value is None, name, value, "left out where body is given")
            require(self.body_force is not None, "body_force", None, "needed where body is given")

    @property
    def on(self) -> str:
        """Name of the body it acts on."""
        return (self.surface or self.body or "").split(".")[0]
