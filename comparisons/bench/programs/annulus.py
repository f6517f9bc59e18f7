"""The body that all programs assemble: a quarter of a thick ring, divided alike everywhere.

Lagrange cells have straight edges, their corners on the ring: the one geometry that every program
knows. NURBS represent the ring exactly.
"""

from dataclasses import dataclass
from math import pi
from typing import Any, Literal, Protocol

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.mesh import Mesh
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Sector

Cell = Literal["hexahedron", "tetrahedron"]
Family = Literal["NURBS", "Q", "P"]
"""NURBS of highest continuity, Lagrange hexahedra, Lagrange tetrahedra."""
Boxes = tuple[int, int, int]
"""Elements along radius, angle and height; tetrahedra are such boxes divided into six."""

INNER, OUTER, HEIGHT = 1.0, 2.0, 0.5
"""Radii and height (m)."""
MATERIAL = IsotropicMaterial(E=1.0, nu=0.3, rho=1.0)
EXACT_VOLUME = pi / 4 * (OUTER**2 - INNER**2) * HEIGHT
"""Volume of the ring itself (m^3); that of cells with straight edges is smaller."""
AROUND = (0, 4, 6, 2, 1, 5, 7, 3)
"""Corners of a hexahedron of :class:`cea.mesh.Mesh` around its bottom, then around its top."""
WEDGES = 6
"""Tetrahedra that a box is divided into."""


@dataclass(frozen=True)
class Discretisation:
    """How the body is divided.

    Parameters
    ----------
    family
        Kind of functions.
    degree
        Degree of the functions.
    boxes
        Elements along each direction.
    """

    family: Family
    degree: int
    boxes: Boxes

    def __post_init__(self) -> None:
        if any(count < 1 for count in self.boxes):
            raise InputError("boxes", self.boxes, "one or more along each direction")

    @property
    def name(self) -> str:
        """Short name, as ``Q2``, ``NURBS3``."""
        return f"{self.family}{self.degree}"

    @property
    def elements(self) -> int:
        """Number of elements."""
        r, theta, z = self.boxes
        return r * theta * z * (WEDGES if self.family == "P" else 1)

    @property
    def stiffness_quadrature(self) -> int:
        """Degree to which every program integrates the stiffness, exact on affine cells."""
        return 2 * (self.degree - 1) if self.family == "P" else 2 * self.degree

    @property
    def mass_quadrature(self) -> int:
        """Degree to which every program integrates the mass, exact on affine cells."""
        return 2 * self.degree

    @property
    def gauss_points(self) -> int:
        """Gauss points along each direction of a box that integrate to those degrees."""
        return self.degree + 1

    @property
    def cell(self) -> Cell:
        """Kind of its Lagrange cells."""
        return "tetrahedron" if self.family == "P" else "hexahedron"

    def mesh(self) -> Mesh:
        """Lagrange cells with straight edges."""
        shape = ring()
        return shape_mesh(shape, self.cell, 1, breaks=breaks_of(shape, self.boxes, {}))


def ring() -> Sector:
    """The shape."""
    return Sector(INNER, OUTER, 0.0, 90.0, 0.0, HEIGHT)


class Assembler(Protocol):
    """A program with the body laid out in it: its space is made, its matrices are not."""

    def __init__(self, discretisation: Discretisation) -> None: ...

    def stiffness(self) -> Any:
        """Elastic stiffness of the free body, in the program's own form, made anew."""

    def mass(self) -> Any:
        """Its mass, in the program's own form, made anew; some give that of one component."""

    def compressed(self, matrix: Any) -> csr_array:
        """A matrix of its own in compressed rows."""

    def motions(self) -> Floats:
        """Coefficients of the six rigid motions (:func:`rigid_motions`), shape (n, 6)."""


def rigid_motions(points: Floats) -> Floats:
    """Three translations and three rotations about the axes by their values at points.

    Parameters
    ----------
    points
        The points, shape (n, 3).

    Returns
    -------
    ndarray
        The three components of each point after each other, shape (3 n, 6).
    """
    motions = np.zeros((len(points), 3, 6))
    motions[:, [0, 1, 2], [0, 1, 2]] = 1.0
    x, y, z = points.T
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 2, 4], motions[:, 0, 4] = -x, z
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    return motions.reshape(-1, 6)
