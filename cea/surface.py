"""What a contact surface must offer, however its body is discretised: points, location, trace.

A contact surface is small beside its volume. Every rank holds the whole of it, geometry and global
scalar dof numbers of one layer of cells, so that points, location and trace need no messages.

Where its normal jumps the surface has a corner. Corners divide it into smooth parts: a point at a
corner has the normal of the element whose coordinates it bears, and rules have one point there for
each part (:mod:`cea.surface_points`).
"""

from abc import abstractmethod
from dataclasses import replace
from functools import cached_property
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from cea.location import Chart
from cea.mesh import lattice
from cea.surface_points import (
    SurfaceCoordinates,
    SurfacePoints,
    connected,
    gauss_rule,
    pairs_of_equal,
)

_MERGE = 1e-7
"""Grid points nearer than this, relative to the spacing on the smallest element, are one."""


class TrueSurface(Protocol):
    """The surface of a shape that facets of a mesh interpolate."""

    def distance(self, x: Floats, direction: Floats) -> Floats:
        """Signed distance (m) to it along unit directions from points x (m), (n, dim): (n,)."""

    def normal(self, x: Floats, near: Floats) -> Floats:
        """Its unit normals at points x (m), outward as those of the facets near them, (n, dim)."""


class Surface(Chart):
    """A named surface (curve in 2D) of a body with so many scalar dofs.

    A backend gives the members marked abstract, here and in :class:`cea.location.Chart`; points,
    normals, location and what corners split are written once. Elements may interpolate a true
    surface of a shape.
    """

    abscissa_kinds: ClassVar[tuple[str, ...]]
    """Kinds of abscissae this surface has: ``nodes``, or ``greville`` and ``botella``."""
    abscissa_weights: ClassVar[tuple[str, ...]]
    """Kinds of weights they may bear: ``equal``, and one more."""

    def __init__(self, name: str, num_scalar_dofs: int, true: TrueSurface | None = None) -> None:
        self.name, self.num_scalar_dofs, self._true = name, num_scalar_dofs, true

    @property
    @abstractmethod
    def element_areas(self) -> Floats:
        """Area (m^2; length in 2D) of each element, shape (num_elements,)."""

    @abstractmethod
    def area_normals(self, at: SurfaceCoordinates) -> tuple[Floats, Floats, Floats]:
        """Positions (m) and outward unit normals, (n, dim) each, and area per area of xi, (n,)."""

    @property
    @abstractmethod
    def function_dofs(self) -> Ints:
        """Scalar dofs of the functions that have a value on each element, element by element."""

    @abstractmethod
    def function_points(self, kind: str) -> SurfaceCoordinates:
        """Abscissae of a kind of these functions, on the same elements."""

    @abstractmethod
    def values(self, at: SurfaceCoordinates, columns: Ints, count: int) -> csr_array:
        """Values of these functions in given columns, one each, of so many: (n, count)."""

    @abstractmethod
    def gradient(self, at: SurfaceCoordinates) -> tuple[csr_array, ...]:
        """Derivatives of the scalar basis functions along x, y, z, each (n, num_scalar_dofs)."""

    @abstractmethod
    def join_smoothly(self, at: SurfaceCoordinates, pairs: Ints) -> NDArray[np.bool_]:
        """Whether elements join smoothly at pairs, (m, 2), of points that lie at one place."""

    @abstractmethod
    def shares(self) -> Floats:
        """Positive shares of the area of the split functions, added up to it, (functions,)."""

    @property
    def num_elements(self) -> int:
        """Number of its elements: facets of a mesh, faces of NURBS patches."""
        return len(self.domains[0])

    @cached_property
    def area(self) -> float:
        """Area (m^2; length in 2D)."""
        return float(self.element_areas.sum())

    @cached_property
    def mesh_size(self) -> float:
        """Largest diameter of its cells (m)."""
        return float(self.size(np.arange(self.num_elements)).max())

    def position(self, at: SurfaceCoordinates) -> Floats:
        """Positions (m), shape (n, dim)."""
        return self.tangents(self.known(at), at.xi)[0]

    def normal(self, at: SurfaceCoordinates) -> Floats:
        """Outward unit normals, shape (n, dim)."""
        self.known(at)
        return self.area_normals(at)[1]

    def known(self, at: SurfaceCoordinates) -> Ints:
        """Elements of points, once checked that none was missed."""
        if len(at) and not 0 <= at.element.min() <= at.element.max() < self.num_elements:
            wrong = [at.element.min(), at.element.max()]
            raise InputError("at.element", wrong, f"0 to {self.num_elements - 1}: points found")
        return at.element

    def offset(self, at: SurfaceCoordinates, direction: Floats) -> Floats:
        """Signed distance (m) along unit directions from the surface to that of the shape, (n,).

        Zero where the surface is that of the shape, or no shape is known.
        """
        if self._true is None:
            return np.zeros(len(at))
        return self._true.distance(self.position(at), direction)

    def normal_error(self, at: SurfaceCoordinates) -> Floats:
        """Normals less those of the shape, (n, dim); zero where no shape is known."""
        normal = self.normal(at)
        if self._true is None:
            return np.zeros_like(normal)
        return normal - self._true.normal(self.position(at), normal)

    def geometry_error(self, at: SurfaceCoordinates) -> Floats:
        """Estimate of how far the true surface lies from where `offset` puts it (m), shape (n,)."""
        return np.zeros(len(at))

    def gauss_points(self, n: int) -> SurfacePoints:
        """Gauss points, n per direction in each cell, weights with the Jacobian.

        In triangles the collapsed product of Gauss-Legendre and Gauss-Jacobi points, exact to
        degree 2n - 1 as in rectangles, the Gauss-Jacobi points along the second direction.
        """
        require(n >= 1, "gauss_points", n, "at least one per direction")
        cells = self.cells()
        t, weights = gauss_rule(n, self.dim - 1, simplex=not cells.tensor)
        at, extent = cells.coordinates(t if cells.tensor else t[:, ::-1])
        x, normal, area = self.area_normals(at)
        return SurfacePoints(at, x, normal, (extent[:, None] * weights).ravel() * area)

    def abscissae(self, kind: str, weights: str = "equal") -> SurfacePoints:
        """Abscissae of the split trace space, each once: at a corner once for each smooth part.

        Weights are ``equal`` shares of the area of each smooth part, or :meth:`shares`.
        """
        kinds, bearing = self.abscissa_kinds, self.abscissa_weights
        require(kind in kinds, "abscissae", kind, f"one of {', '.join(kinds)}")
        require(weights in bearing, "weights", weights, f"one of {', '.join(bearing)}")
        first = np.sort(np.unique(self.functions, return_index=True)[1])
        points = self._even(self.function_points(kind)[first])
        if weights == "equal":
            return points
        return replace(points, weight=self.shares()[self.functions[first]])

    def grid(self, n: int) -> SurfacePoints:
        """Equally spaced points, shared ones once: at a corner once for each smooth part.

        n per direction over each face of a NURBS patch (in its parameters), or n per side of each
        facet of a mesh; both include the boundary. The area of each smooth part is shared evenly
        among its points.
        """
        require(n >= 2, "grid", n, "at least two points per direction, the ends")
        low, high = self.domains
        t = lattice(self.dim - 1, n - 1, not self.cells().tensor) / (n - 1)
        xi = low[:, None] + t * (high - low)[:, None]
        element = np.repeat(np.arange(len(low)), len(t))
        at = SurfaceCoordinates(element, xi.reshape(-1, self.dim - 1))
        nearest = float(self.size(np.arange(self.num_elements)).min()) / (n - 1)
        tree = cKDTree(self.position(at))
        twins = tree.query_pairs(_MERGE * nearest, output_type="ndarray")
        groups = connected(twins[self.join_smoothly(at, twins)], len(at))
        return self._even(at[np.sort(np.unique(groups, return_index=True)[1])])

    def trace(self, at: SurfaceCoordinates) -> csr_array:
        """Values of the scalar basis functions, shape (n, num_scalar_dofs)."""
        self.known(at)
        return self.values(at, self.function_dofs, self.num_scalar_dofs)

    def split_trace(self, at: SurfaceCoordinates) -> csr_array:
        """Values of the trace functions split at corners, shape (n, num_scalar_dofs + further).

        A function that reaches over a corner is one function for each smooth part: one in its own
        column, the others in further columns.
        """
        self.known(at)
        count = max(self.num_scalar_dofs, int(self.functions.max(initial=0)) + 1)
        return self.values(at, self.functions, count)

    @cached_property
    def functions(self) -> Ints:
        """Numbers of the trace functions split at corners, as :attr:`function_dofs`."""
        dofs = self.function_dofs
        pairs = pairs_of_equal(dofs)
        smooth = self.join_smoothly(self.function_points(self.abscissa_kinds[0]), pairs)
        groups = connected(pairs[smooth], len(dofs))
        number = dofs[np.unique(groups, return_index=True)[1]]
        further = np.ones(len(number), dtype=bool)
        further[np.unique(number, return_index=True)[1]] = False
        number[further] = self.num_scalar_dofs + np.arange(further.sum())
        return number[groups]

    @cached_property
    def _parts(self) -> Ints:
        """Smooth part of each element, (num_elements,): those that share a split function."""
        element = self.function_points(self.abscissa_kinds[0]).element
        pairs = np.column_stack([element, self.num_elements + self.functions])
        return connected(pairs, int(pairs.max()) + 1)[: self.num_elements]

    def _even(self, at: SurfaceCoordinates) -> SurfacePoints:
        """Points that share the area of their smooth part evenly."""
        x, normal, _ = self.area_normals(at)
        part = self._parts[at.element]
        areas = np.bincount(self._parts, weights=self.element_areas)
        number = np.maximum(np.bincount(part, minlength=len(areas)), 1)
        weight = (self.area * (areas / areas.sum()) / number)[part]
        return SurfacePoints(at, x, normal, weight)
