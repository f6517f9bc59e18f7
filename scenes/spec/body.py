"""Section of a body in a scene: geometry, meshes, material, supports, damping, loads."""

from dataclasses import dataclass, field
from math import pi
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag

from cea.errors import require
from cea.material import AnisotropicMaterial, IsotropicMaterial, OrthotropicMaterial
from cea.mesh import SIMPLICES, Cell
from cea.motion import ModalDamping, RayleighDamping, Rotation
from cea.supports.boundary import Force, Pressure, Spring, Support
from meshes.mesh_file import MeshFile
from meshes.patches import NurbsFile, Patches
from meshes.placement import Placement
from meshes.shapes import Shape, VentilatedDisc

Backend = Literal["fe", "iga"]


def kind(given: Any) -> Any:
    """Return the kind of a material; error messages use the function's name as the field."""
    if isinstance(given, dict):
        return given.get("kind", "isotropic")
    return getattr(given, "kind", "isotropic")


def _without_kind(given: Any) -> Any:
    """Return the data of an isotropic material without the field ``kind``."""
    return {k: v for k, v in given.items() if k != "kind"} if isinstance(given, dict) else given


Material = Annotated[
    Annotated[IsotropicMaterial, BeforeValidator(_without_kind), Tag("isotropic")]
    | Annotated[OrthotropicMaterial, Tag("orthotropic")]
    | Annotated[AnisotropicMaterial, Tag("anisotropic")],
    Discriminator(kind),
]


BACKEND_NAMES = {"fe": "finite elements", "iga": "NURBS"}
"""Displayed name of each backend."""


def backend_name(backend: str) -> str:
    """Return the displayed name of a backend, or of several: "fe+iga"."""
    return " and ".join(BACKEND_NAMES.get(part, part) for part in backend.split("+"))


def file_name(name: str) -> str:
    """Return the name of a scene for file names: only letters, digits, _ and -, others become _."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)


@dataclass(frozen=True)
class DampingSpec:
    """Damping of a body: Rayleigh damping C = alpha M + beta K, modal damping, or both.

    Rayleigh damping is given by its factors or by damping ratios at two frequencies.

    Parameters
    ----------
    alpha
        Factor of the mass matrix (1/s).
    beta
        Factor of the stiffness matrix (s).
    ratios
        Damping ratios at two frequencies, instead of alpha and beta; 1 is critical damping.
    frequencies
        The two frequencies (Hz) of ``ratios``.
    modal
        Damping ratios of the modes of the uncoupled body.
    """

    alpha: float | None = None
    beta: float | None = None
    ratios: tuple[float, float] | None = None
    frequencies: tuple[float, float] | None = None
    modal: ModalDamping | None = None

    def __post_init__(self) -> None:
        ways = [self.alpha is not None or self.beta is not None, self.ratios is not None]
        allowed = "alpha, beta or both; or ratios with frequencies; and modal, alone or with these"
        one_way = any(ways) or self.modal is not None
        require(one_way and not all(ways), "ratios", self.ratios, allowed)
        both = (self.ratios is None) == (self.frequencies is None)
        require(both, "frequencies", self.frequencies, "two, if and only if ratios are given")
        self.rayleigh()

    @property
    def acts(self) -> bool:
        """Whether any damping is nonzero."""
        modal = self.modal is not None and self.modal.acts
        return modal or self.rayleigh() not in (None, RayleighDamping())

    @property
    def in_factors(self) -> "DampingSpec":
        """The same damping with alpha and beta instead of damping ratios."""
        found = self.rayleigh()
        return self if found is None else DampingSpec(found.alpha, found.beta, modal=self.modal)

    def rayleigh(self) -> RayleighDamping | None:
        """Return the Rayleigh damping; None if there is only modal damping."""
        if self.ratios is not None and self.frequencies is not None:
            return RayleighDamping.of_ratios(self.ratios, self.frequencies)
        if self.alpha is None and self.beta is None:
            return None
        return RayleighDamping(self.alpha or 0.0, self.beta or 0.0)


@dataclass(frozen=True)
class FeMesh:
    """Lagrange mesh of a body.

    Parameters
    ----------
    cell
        Kind of cell.
    degree
        Degree of the elements.
    geometry_degree
        Degree of the geometry; by default that of the elements. 1 gives straight facets.
    elements
        Number of boxes of a structured mesh along each direction of the shape, over the full
        circumference of closed shapes. A box is one quadrilateral or hexahedron, two triangles or
        six tetrahedra.
    size
        Target edge length of unstructured tetrahedra or triangles (m), instead of ``elements``.
    through
        Coordinates that must be element boundaries of a structured mesh, by direction.
    edges
        Singular edges of a structured mesh of quadrilaterals or hexahedra, each given by its two
        coordinates, which become element boundaries. All run along one direction; in the plane
        they are points.
    layers
        Number of geometric layers towards the edges; only the cells at the edges are divided.
    """

    cell: Cell = "hexahedron"
    degree: Annotated[int, Field(ge=1, le=4)] = 2
    geometry_degree: Annotated[int, Field(ge=1, le=4)] | None = None
    elements: tuple[int, ...] | None = None
    size: Annotated[float, Field(gt=0)] | None = None
    through: dict[str, tuple[float, ...]] = field(default_factory=dict)
    edges: tuple[dict[str, float], ...] = ()
    layers: Annotated[int, Field(ge=0, le=8)] = 0

    def __post_init__(self) -> None:
        simplices, cell = self.cell in SIMPLICES, f"cell = {self.cell!r}"
        sized, counted = self.size is not None, self.elements is not None
        either = f"either size (unstructured) or elements (divided boxes) for {cell}"
        require(not (self.edges and simplices), "edges", self.edges, f"left out for {cell}")
        require(not self.layers or bool(self.edges), "layers", self.layers, "0 without edges")
        require(simplices or counted, "elements", None, f"needed for {cell}")
        require(simplices or not sized, "size", self.size, f"left out for {cell}")
        require(not simplices or counted != sized, "size", self.size, either)
        require(counted or not self.through, "through", self.through, "left out with size")

    @property
    def boundaries(self) -> dict[str, tuple[float, ...]]:
        """Coordinates that must be element boundaries, including those of edges, by direction."""
        found = {name: set(values) for name, values in self.through.items()}
        for edge in self.edges:
            for name, value in edge.items():
                found.setdefault(name, set()).add(value)
        return {name: tuple(sorted(values)) for name, values in found.items()}


@dataclass(frozen=True)
class IgaMesh:
    """NURBS discretisation of a body.

    Parameters
    ----------
    degree
        Degree along each direction.
    elements
        Number of knot spans along each direction of the shape, over the full circumference of
        closed shapes.
    continuity
        Continuity at inner knots; by default one less than the degree.
    through
        Coordinates that must be knots, by direction.
    """

    degree: tuple[Annotated[int, Field(ge=1, le=8)], ...]
    elements: tuple[int, ...]
    continuity: tuple[Annotated[int, Field(ge=0)], ...] | None = None
    through: dict[str, tuple[float, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        continuity = self.continuity or ()
        below = all(c < p for c, p in zip(continuity, self.degree, strict=False))
        require(below, "continuity", continuity, f"below the degree {self.degree}")

    @property
    def continuities(self) -> tuple[int, ...]:
        """Continuity at inner knots along each direction."""
        return self.continuity or tuple(p - 1 for p in self.degree)


@dataclass(frozen=True)
class MeshSpec:
    """Discretisations of a body, one for each backend that it can run on.

    Parameters
    ----------
    fe
        Lagrange mesh of a shape.
    iga
        NURBS discretisation.
    degree
        Degree of the elements on the cells of a mesh file; by default the order of the cells, and
        2 or more where cells of a mixed mesh are divided into tetrahedra.
    """

    fe: FeMesh | None = None
    iga: IgaMesh | None = None
    degree: Annotated[int, Field(ge=1, le=4)] | None = None


class Face(NamedTuple):
    """A face normal to a direction, at its end 0 or 1, and its coordinate along it."""

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
"""Names of the surfaces at the lower and upper end of each direction."""


@dataclass(frozen=True)
class BodySpec:
    """A body: backend, geometry, meshes, material, supports, damping, rotation.

    Parameters
    ----------
    backend
        ``fe`` for Lagrange elements, ``iga`` for NURBS.
    geometry
        Shape of the body in its own coordinates.
    material
        Linear elasticity, isotropic if no ``kind`` is given.
    mesh
        Discretisation for each backend that the body can run on.
    supports
        Prescribed displacements, zero by default.
    springs
        Elastic foundations of surfaces.
    placement
        Rotation and translation of the shape in space.
    damping
        Rayleigh and modal damping.
    rotation
        Steady rotation about the body's own axis, in the frame at rest.
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
        """Faces of the shape normal to its coordinate directions, by surface name."""
        shape, found = self.geometry, {}
        for direction, ends in zip(shape.directions, shape.extent, strict=True):
            for end, names in enumerate(_FACES.get(direction, ())):
                for name in names:
                    at = getattr(shape, name, ends[end]) if direction == "z" else ends[end]
                    found[name] = Face(direction, end, float(at))
        return {name: face for name, face in found.items() if name in shape.surfaces}

    @property
    def circulates(self) -> bool:
        """Whether the body both rotates and is damped, which adds circulatory terms."""
        return self.rotation is not None and self.damping is not None

    @property
    def rotates_in_equilibrium(self) -> bool:
        """Whether the rotation adds forces on displacements that are constant in space."""
        convective = self.rotation is not None and self.rotation.convective_stiffness
        return convective or self.circulates

    @property
    def lengths(self) -> list[float]:
        """Edge lengths (m) of an equivalent box; arcs are measured at the mean radius."""
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
        """Mesh for the body's backend; None for a mesh file."""
        return self.mesh.fe if self.backend == "fe" else self.mesh.iga

    @property
    def degree(self) -> int:
        """Lowest degree of the elements over the directions."""
        mesh = self.division
        return min(mesh.degree) if isinstance(mesh, IgaMesh) else self.fe_degree or 0

    @property
    def smooth(self) -> bool:
        """Whether the elements are splines that are at least C1 in every direction."""
        mesh = self.division
        return isinstance(mesh, IgaMesh) and min(mesh.continuities) > 0

    @property
    def fe_degree(self) -> int | None:
        """Degree of the Lagrange elements; None without a Lagrange mesh."""
        if isinstance(self.geometry, MeshFile):
            elements = self.geometry.elements
            least = 2 if elements.is_divided else 1  # linear tetrahedra are too stiff
            return self.mesh.degree or max(elements.order, least)
        return self.mesh.fe.degree if self.mesh.fe is not None else None


@dataclass(frozen=True)
class LoadSpec:
    """A load: a pressure or a force on a surface, or a body force.

    Parameters
    ----------
    surface
        The surface "body.surface".
    pressure
        Uniform pressure on the surface (N/m^2); positive values push on the body.
    force
        Components of a force (N; N/m in the plane), distributed uniformly over the surface.
    body
        The body that ``body_force`` acts on, instead of ``surface``.
    body_force
        Components of a force per unit volume (N/m^3).
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
        """Name of the loaded body."""
        return (self.surface or self.body or "").partition(".")[0]

    @property
    def applied(self) -> Pressure | Force:
        """The load on that body."""
        surface = None if self.surface is None else self.surface.partition(".")[2]
        if surface is not None and self.pressure is not None:
            return Pressure(surface, self.pressure)
        return Force(self.force or self.body_force or (), surface)
