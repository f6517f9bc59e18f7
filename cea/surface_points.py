"""Points, cells and locations of contact surfaces: plain data."""

from dataclasses import dataclass
from enum import IntEnum
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import roots_jacobi, roots_legendre

from cea.arrays import Floats, Ints


class Status(IntEnum):
    """Outcome of locating one point on a surface."""

    INSIDE = 0
    EDGE = 1
    MISSED = 2


@dataclass(frozen=True)
class SurfaceCoordinates:
    """Points of a surface in its own coordinates.

    Parameters
    ----------
    element
        Surface element (facet, or face of a patch) that holds each point, shape (n,).
    xi
        Reference coordinates in that element, shape (n, dim - 1).
    """

    element: Ints
    xi: Floats

    def __len__(self) -> int:
        return len(self.element)

    def __getitem__(self, rows: Any) -> "SurfaceCoordinates":
        return SurfaceCoordinates(self.element[rows], self.xi[rows])


@dataclass(frozen=True)
class SurfacePoints:
    """Points of a rule on a surface.

    Parameters
    ----------
    at
        Where the points lie, in coordinates of the surface.
    x
        Positions (m), shape (n, dim).
    normal
        Outward unit normals, shape (n, dim).
    weight
        Area weights (m^2; m in 2D), shape (n,).
    """

    at: SurfaceCoordinates
    x: Floats
    normal: Floats
    weight: Floats

    def __len__(self) -> int:
        return len(self.x)

    def __getitem__(self, rows: Any) -> "SurfacePoints":
        return SurfacePoints(self.at[rows], self.x[rows], self.normal[rows], self.weight[rows])


@dataclass(frozen=True)
class SurfaceCells:
    """Cells of a surface, inside which its traces are smooth: facets, or knot spans of patches.

    Parameters
    ----------
    element
        Surface element of each cell, shape (n,).
    corners
        Corners in the element's coordinates, in cyclic order, shape (n, corners, dim - 1).
    degree
        Highest degree of the traces along a direction.
    tensor
        Whether traces have that degree along each direction, rather than in all.
    """

    element: Ints
    corners: Floats
    degree: int
    tensor: bool

    def coordinates(self, t: Floats) -> tuple[SurfaceCoordinates, Floats]:
        """The same points of each cell, cell by cell, and the extent of each in xi, (n,)."""
        first = self.corners[:, :1]
        edges = self.corners[:, [1, -1][: t.shape[1]]] - first
        xi = first + t @ edges
        extent = np.abs(np.linalg.det(edges))
        at = SurfaceCoordinates(np.repeat(self.element, len(t)), xi.reshape(-1, t.shape[1]))
        return at, extent


@dataclass(frozen=True)
class Location:
    """Points found, or missed, on a surface along given directions.

    Parameters
    ----------
    at
        Where each point was found; the nearest candidate where it was missed.
    distance
        Signed distance (m) along the direction from the point to the surface, shape (n,).
    miss
        Distance (m) by which the line through the point misses the surface, shape (n,);
        infinite where no element was near enough to try.
    status
        One :class:`Status` per point, shape (n,).
    tolerance
        Miss allowed, relative to the local mesh size.
    """

    at: SurfaceCoordinates
    distance: Floats
    miss: Floats
    status: NDArray[np.int8]
    tolerance: float

    def __getitem__(self, rows: Any) -> "Location":
        distance, miss, status = self.distance[rows], self.miss[rows], self.status[rows]
        return Location(self.at[rows], distance, miss, status, self.tolerance)

    @property
    def missed(self) -> NDArray[np.bool_]:
        """True where a point was missed, shape (n,)."""
        return self.status == Status.MISSED


def lattice(n: int, dim: int, *, simplex: bool) -> Ints:
    """Points i, j >= 0 of a lattice in C order: i, j <= n, or i + j <= n, shape (m, dim)."""
    points = np.array(list(product(range(n + 1), repeat=dim)))
    return points[points.sum(axis=1) <= n] if simplex else points


def gauss_rule(n: int, dim: int, *, simplex: bool) -> tuple[Floats, Floats]:
    """Points (m, dim) and weights (m,), n per direction, of the unit interval, square or triangle.

    In a triangle collapsed, with Gauss-Jacobi points along the first direction. Weights add up to
    the length or area.
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
