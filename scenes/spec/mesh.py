"""Section of the mesh of a body in a scene."""

from dataclasses import dataclass, field
from typing import Annotated

from pydantic import Field

from cea.errors import require
from cea.mesh import SIMPLICES, Cell


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
