"""What a contact surface must offer, however its body is discretised: points, location, trace.

A contact surface is small beside its volume. Every rank holds the whole of it, geometry and global
scalar dof numbers of one layer of cells, so that points, location and trace need no messages.

Where its normal jumps the surface has a corner. Corners divide it into smooth parts: a point at a
corner has the normal of the element whose coordinates it bears, and rules have one point there for
each part (:mod:`cea.corners`).
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

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

    @property
    def missed(self) -> NDArray[np.bool_]:
        """True where a point was missed, shape (n,)."""
        return self.status == Status.MISSED


class TrueSurface(Protocol):
    """The surface of a shape that facets of a mesh interpolate."""

    def distance(self, x: Floats, direction: Floats) -> Floats:
        """Signed distance (m) along directions from points beside the surface to it, (n,).

        Parameters
        ----------
        x
            Points (m), shape (n, dim).
        direction
            Unit directions that do not lie in the surface, shape (n, dim).
        """
        ...

    def normal(self, x: Floats, near: Floats) -> Floats:
        """Unit normals, shape (n, dim), at points beside the surface (m), shape (n, dim).

        Parameters
        ----------
        x
            Points (m), shape (n, dim).
        near
            Unit normals of the facets there, which tell the outside, shape (n, dim).
        """
        ...


class Surface(Protocol):
    """A named surface (curve in 2D) of a body."""

    @property
    def name(self) -> str:
        """Name of the surface."""
        ...

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""
        ...

    @property
    def num_scalar_dofs(self) -> int:
        """Scalar dofs of the body: columns of the trace."""
        ...

    @property
    def area(self) -> float:
        """Area (m^2; length in 2D)."""
        ...

    @property
    def num_elements(self) -> int:
        """Number of its elements: facets of a mesh, faces of NURBS patches."""
        ...

    @property
    def mesh_size(self) -> float:
        """Largest diameter of its elements (m)."""
        ...

    @property
    def abscissa_kinds(self) -> tuple[str, ...]:
        """Kinds of abscissae this surface has: ``nodes``, or ``greville`` and ``botella``."""
        ...

    @property
    def abscissa_weights(self) -> tuple[str, ...]:
        """Kinds of weights they may bear: ``equal``, and ``tributary`` or ``area``."""
        ...

    def cells(self) -> SurfaceCells:
        """Cells inside which the traces are smooth."""
        ...

    def gauss_points(self, n: int) -> SurfacePoints:
        """Gauss points, n per direction in each cell, weights with the Jacobian."""
        ...

    def abscissae(self, kind: str, weights: str = "equal") -> SurfacePoints:
        """Abscissae of the split trace space, each once: at a corner once for each smooth part.

        Parameters
        ----------
        kind
            One of ``abscissa_kinds``.
        weights
            One of ``abscissa_weights``: ``equal`` shares the area of each smooth part evenly among
            its points; the others give positive shares of the area by the split trace functions,
            added up to the area.

        Raises
        ------
        InputError
            When the surface has no abscissae or weights of this kind.
        """
        ...

    def grid(self, n: int) -> SurfacePoints:
        """Equally spaced points, shared ones once: at a corner once for each smooth part.

        n per direction over each face of a NURBS patch (in its parameters), or n per side of each
        facet of a mesh; both include the boundary. The area of each smooth part is shared evenly
        among its points.
        """
        ...

    def locate(self, x: Floats, direction: Floats, reach: float) -> Location:
        """Find points on the surface along a direction.

        Parameters
        ----------
        x
            Points (m), shape (n, dim).
        direction
            Unit directions, shape (n, dim).
        reach
            Largest distance (m) along the direction, either way.
        """
        ...

    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Positions (m), (n, dim), and derivatives dx_i/dxi_j, (n, dim, dim - 1).

        Outside its element xi is taken by the continued polynomials.
        """
        ...

    def position(self, at: SurfaceCoordinates) -> Floats:
        """Positions (m), shape (n, dim)."""
        ...

    def normal(self, at: SurfaceCoordinates) -> Floats:
        """Outward unit normals, shape (n, dim)."""
        ...

    def offset(self, at: SurfaceCoordinates, direction: Floats) -> Floats:
        """Signed distance (m) from the surface as meshed to that of the shape, shape (n,).

        Zero where the surface is that of the shape, or no shape is known.

        Parameters
        ----------
        at
            Points of the surface.
        direction
            Unit directions along which it is measured, shape (n, dim).
        """
        ...

    def normal_error(self, at: SurfaceCoordinates) -> Floats:
        """Normals as meshed less those of the shape, shape (n, dim).

        Zero where the surface is that of the shape, or no shape is known.
        """
        ...

    def geometry_error(self, at: SurfaceCoordinates) -> Floats:
        """Estimate of how far the true surface lies from where `offset` puts it (m), shape (n,)."""
        ...

    def trace(self, at: SurfaceCoordinates) -> csr_array:
        """Values of the scalar basis functions, shape (n, num_scalar_dofs)."""
        ...

    def split_trace(self, at: SurfaceCoordinates) -> csr_array:
        """Values of the trace functions split at corners, shape (n, num_scalar_dofs + further).

        A function that reaches over a corner is one function for each smooth part: one in its own
        column, the others in further columns. Without corners it is the trace.
        """
        ...

    def gradient(self, at: SurfaceCoordinates) -> tuple[csr_array, ...]:
        """Derivatives of the scalar basis functions along x, y, z, each (n, num_scalar_dofs)."""
        ...
