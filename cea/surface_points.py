"""Points, cells and locations of contact surfaces, and corners, where the normal jumps.

Contact constrains the gap along one normal at each point. A trace function that extends over a
corner would average gaps along two normals: it is split into one function per smooth part of the
surface. Likewise a point at a corner becomes one point per smooth part, with the normal and the
area of that part.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, triu
from scipy.special import roots_jacobi, roots_legendre

from cea.arrays import Floats, Ints

TANGENT = np.cos(np.deg2rad(1.0))
"""Smallest cosine between normals of faces that join smoothly.

CAD programs treat faces as tangent to within about one degree.
"""


class Status(IntEnum):
    """Outcome of locating one point on a surface."""

    INSIDE = 0
    EDGE = 1
    MISSED = 2


@dataclass(frozen=True)
class SurfaceCoordinates:
    """Points of a surface in surface coordinates."""

    element: Ints  # facet, or face of a patch, that contains each point, shape (n,)
    xi: Floats  # reference coordinates in that element, shape (n, dim - 1)

    def __len__(self) -> int:
        return len(self.element)

    def __getitem__(self, rows: Any) -> "SurfaceCoordinates":
        return SurfaceCoordinates(self.element[rows], self.xi[rows])


@dataclass(frozen=True)
class SurfacePoints:
    """Points and weights of a quadrature rule on a surface."""

    at: SurfaceCoordinates
    x: Floats  # positions (m), shape (n, dim)
    normal: Floats  # outward unit normals, shape (n, dim)
    weight: Floats  # area weights (m^2; m in 2D), shape (n,)

    def __len__(self) -> int:
        return len(self.x)

    def __getitem__(self, rows: Any) -> "SurfacePoints":
        return SurfacePoints(self.at[rows], self.x[rows], self.normal[rows], self.weight[rows])


@dataclass(frozen=True)
class SurfaceCells:
    """Cells of a surface, inside which its traces are smooth: facets, or knot spans of patches."""

    element: Ints  # surface element of each cell, shape (n,)
    corners: Floats  # in coordinates of the element, in cyclic order, shape (n, corners, dim - 1)
    degree: int  # highest degree of the traces along a direction
    tensor: bool  # whether the degree is that in each direction, not the total degree

    def coordinates(self, t: Floats) -> tuple[SurfaceCoordinates, Floats]:
        """Return points t of each cell, cell by cell, and the extent of each cell in xi, (n,)."""
        first = self.corners[:, :1]
        edges = self.corners[:, [1, -1][: t.shape[1]]] - first
        xi = first + t @ edges
        extent = np.abs(np.linalg.det(edges))
        at = SurfaceCoordinates(np.repeat(self.element, len(t)), xi.reshape(-1, t.shape[1]))
        return at, extent


@dataclass(frozen=True)
class Location:
    """Result of locating points on a surface along given directions."""

    at: SurfaceCoordinates  # location of each point, or its nearest candidate if it was missed
    distance: Floats  # signed distance (m) along the direction to the surface, shape (n,)
    status: NDArray[np.int8]  # one :class:`Status` per point, shape (n,)
    # distance by which the line of a located point may miss the surface, in local mesh sizes
    tolerance: float

    def __getitem__(self, rows: Any) -> "Location":
        return Location(self.at[rows], self.distance[rows], self.status[rows], self.tolerance)

    @property
    def missed(self) -> NDArray[np.bool_]:
        """True for missed points, shape (n,)."""
        return self.status == Status.MISSED


def gauss_rule(n: int, dim: int, *, simplex: bool) -> tuple[Floats, Floats]:
    """Return Gauss points (m, dim) and weights (m,) of the unit interval, square or triangle.

    There are n per direction; triangles have Gauss-Jacobi points along the first direction.
    """
    t, w = roots_legendre(n)
    t, w = (1 + t) / 2, w / 2
    if dim == 1:
        return t[:, None], w
    first, weight = (t, w)
    if simplex:
        first, weight = roots_jacobi(n, 1.0, 0.0)
        first, weight = (1 + first) / 2, weight / 4
    across = np.where(simplex, 1 - first, 1.0)
    points = np.stack([np.repeat(first, n), np.outer(across, t).ravel()], axis=1)
    return points, np.outer(weight, w).ravel()


def pairs_of_equal(numbers: Ints) -> Ints:
    """Return all pairs of entries with the same number, shape (pairs, 2)."""
    n = len(numbers)
    shape = (n, int(numbers.max(initial=0)) + 1)
    has = csr_array((np.ones(n, dtype=np.int8), numbers, np.arange(n + 1)), shape=shape)
    return np.column_stack(triu(has @ has.T, k=1).coords).astype(np.int64)
