"""Contact surfaces of any discretisation: quadrature points, point location, traces.

A contact surface is small compared with its volume. Every rank holds all of its geometry and the
communication.

Where the normal jumps the surface has a corner. Corners divide it into smooth parts: a point at a
corner has the normal of the element of its coordinates, and rules have one point there for each
smooth part (:mod:`cea.surface_points`).
"""

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import cached_property
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints, chunks, connected
from cea.errors import InputError, require
from cea.location import CellBounds, apart, cross, near_boxes, newton_step
from cea.mesh import lattice
from cea.surface_points import (
    Location,
    Status,
    SurfaceCells,
    SurfaceCoordinates,
    SurfacePoints,
    gauss_rule,
    pairs_of_equal,
)

TOLERANCE = 1e-8
"""Default tolerance for the distance by which a line misses a surface, in local mesh sizes."""

_MERGE = 1e-7
"""Distance, relative to the spacing on the smallest element, below which points are merged."""
_MAX_ITERATIONS = 40
_PER_POINT = 1280  # bytes of temporaries per point
_NEAR = 1.05
"""Multiple of a cell's bounding radius within which a line passes to be a candidate."""


class TrueSurface(Protocol):
    """The exact surface that the facets of a mesh interpolate."""

    def distance(self, x: Floats, direction: Floats) -> Floats:
        """Return the signed distance (m) to it along unit directions from x (m), (n, dim): (n,)."""

    def normal(self, x: Floats, near: Floats) -> Floats:
        """Return its unit normals at x (m), on the same side as the normals ``near``, (n, dim)."""


class Surface(ABC):
    """A named surface (curve in 2D) of a body.

    A backend implements the abstract members; points, normals, location and the splitting of traces
    at corners are common. Elements may interpolate an exact surface.
    """

    abscissa_kinds: ClassVar[tuple[str, ...]]
    """Kinds of abscissae this surface has: ``nodes``, or ``greville`` and ``botella``."""
    abscissa_weights: ClassVar[tuple[str, ...]]
    """Kinds of weights of the abscissae: ``equal``, and one more."""

    def __init__(self, name: str, num_scalar_dofs: int, true: TrueSurface | None = None) -> None:
        self.name, self.num_scalar_dofs, self._true = name, num_scalar_dofs, true

    @property
    @abstractmethod
    def domains(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of xi of each element, (num_elements, dim - 1) each.

        Elements are rectangles with these bounds or, if cells are not tensor products, triangles.
        """

    @property
    @abstractmethod
    def cells(self) -> SurfaceCells:
        """Cells inside which traces are smooth: parallelograms or triangles of xi."""

    @property
    @abstractmethod
    def sizes(self) -> Floats:
        """Local mesh size (m) of each element, its largest cell diameter, (num_elements,)."""

    @abstractmethod
    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Return positions (m), (n, dim), and derivatives dx_i/dxi_j, (n, dim, dim - 1).

        Outside the element the polynomials of the element are extrapolated.
        """

    @property
    @abstractmethod
    def element_areas(self) -> Floats:
        """Area (m^2; length in 2D) of each element, shape (num_elements,)."""

    @abstractmethod
    def area_normals(self, at: SurfaceCoordinates) -> tuple[Floats, Floats, Floats]:
        """Return positions (m), outward unit normals, (n, dim), area per area of xi, (n,)."""

    @property
    @abstractmethod
    def function_dofs(self) -> Ints:
        """Scalar dofs of the functions that are nonzero on each element, element by element."""

    @abstractmethod
    def function_points(self, kind: str) -> SurfaceCoordinates:
        """Return the abscissae of these functions, in the same order."""

    @abstractmethod
    def values(self, at: SurfaceCoordinates, columns: Ints, count: int) -> csr_array:
        """Return values of these functions, function i in column ``columns[i]``, (n, count)."""

    @abstractmethod
    def gradient(self, at: SurfaceCoordinates) -> tuple[csr_array, ...]:
        """Return derivatives of the scalar basis along x, y, z, each (n, num_scalar_dofs)."""

    @abstractmethod
    def join_smoothly(self, at: SurfaceCoordinates, pairs: Ints) -> NDArray[np.bool_]:
        """Return whether elements join smoothly at pairs (m, 2) of coincident points."""

    @abstractmethod
    def shares(self) -> Floats:
        """Return positive area weights of the split functions, whose sum is the area."""

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""
        return self.domains[0].shape[1] + 1

    @property
    def num_elements(self) -> int:
        """Number of elements: facets of a mesh, or faces of NURBS patches."""
        return len(self.domains[0])

    @cached_property
    def area(self) -> float:
        """Area (m^2; length in 2D)."""
        return float(self.element_areas.sum())

    @cached_property
    def mesh_size(self) -> float:
        """Largest cell diameter (m)."""
        return float(self.sizes.max())

    def position(self, at: SurfaceCoordinates) -> Floats:
        """Return positions (m), shape (n, dim)."""
        return self.tangents(self.known(at), at.xi)[0]

    def normal(self, at: SurfaceCoordinates) -> Floats:
        """Return outward unit normals, shape (n, dim)."""
        self.known(at)
        return self.area_normals(at)[1]

    def known(self, at: SurfaceCoordinates) -> Ints:
        """Return the elements of points; raise InputError if a point was missed."""
        if len(at) and not 0 <= at.element.min() <= at.element.max() < self.num_elements:
            wrong = [at.element.min(), at.element.max()]
            raise InputError("at.element", wrong, f"0 to {self.num_elements - 1}: located points")
        return at.element

    def offset(self, at: SurfaceCoordinates, direction: Floats) -> Floats:
        """Return the signed distance (m), along unit directions, to the exact surface, (n,).

        Zero if the surface is exact, or the exact one is unknown.
        """
        if self._true is None:
            return np.zeros(len(at))
        return self._true.distance(self.position(at), direction)

    def normal_error(self, at: SurfaceCoordinates) -> Floats:
        """Return normals minus exact normals, (n, dim); zero if the exact surface is unknown."""
        normal = self.normal(at)
        if self._true is None:
            return np.zeros_like(normal)
        return normal - self._true.normal(self.position(at), normal)

    def geometry_error(self, at: SurfaceCoordinates) -> Floats:
        """Return an error estimate (m) of the exact surface given by `offset`, shape (n,)."""
        return np.zeros(len(at))

    def gauss_points(self, n: int) -> SurfacePoints:
        """Return Gauss points, n per direction in each cell; weights include the Jacobian.

        Triangles have the collapsed product of Gauss-Legendre and Gauss-Jacobi points, the latter
        along the second direction; the rule is exact to degree 2n - 1, as in rectangles.
        """
        require(n >= 1, "gauss_points", n, "at least one per direction")
        cells = self.cells
        t, weights = gauss_rule(n, self.dim - 1, simplex=not cells.tensor)
        at, extent = cells.coordinates(t if cells.tensor else t[:, ::-1])
        x, normal, area = self.area_normals(at)
        return SurfacePoints(at, x, normal, (extent[:, None] * weights).ravel() * area)

    def abscissae(self, kind: str, weights: str = "equal") -> SurfacePoints:
        """Return the abscissae of the split traces, with one point per smooth part at corners.

        Weights are ``equal`` shares of the area of each smooth part, or from :meth:`shares`.
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
        """Return equally spaced points without duplicates, one per smooth part at corners.

        There are n per direction over each face of a NURBS patch (in its parameters), or n per side
        of each facet of a mesh; both include the boundary. The points of each smooth part share its
        area equally.
        """
        require(n >= 2, "grid", n, "at least two points per direction, the ends")
        low, high = self.domains
        t = lattice(self.dim - 1, n - 1, not self.cells.tensor) / (n - 1)
        xi = low[:, None] + t * (high - low)[:, None]
        element = np.repeat(np.arange(len(low)), len(t))
        at = SurfaceCoordinates(element, xi.reshape(-1, self.dim - 1))
        nearest = float(self.sizes.min()) / (n - 1)
        tree = cKDTree(self.position(at))
        twins = tree.query_pairs(_MERGE * nearest, output_type="ndarray")
        groups = connected(twins[self.join_smoothly(at, twins)], len(at))
        return self._even(at[np.sort(np.unique(groups, return_index=True)[1])])

    def trace(self, at: SurfaceCoordinates) -> csr_array:
        """Return values of the scalar basis functions, shape (n, num_scalar_dofs)."""
        self.known(at)
        return self.values(at, self.function_dofs, self.num_scalar_dofs)

    def split_trace(self, at: SurfaceCoordinates) -> csr_array:
        """Return values of the traces split at corners, shape (n, num_scalar_dofs + further).

        A function that extends over a corner is split into one function per smooth part: one keeps
        its column, the others have further columns.
        """
        self.known(at)
        count = max(self.num_scalar_dofs, int(self.functions.max(initial=0)) + 1)
        return self.values(at, self.functions, count)

    @cached_property
    def functions(self) -> Ints:
        """Numbers of the traces split at corners, in the order of :attr:`function_dofs`."""
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
        """Smooth part of each element, (num_elements,); its elements share split functions."""
        element = self.function_points(self.abscissa_kinds[0]).element
        pairs = np.column_stack([element, self.num_elements + self.functions])
        return connected(pairs, int(pairs.max()) + 1)[: self.num_elements]

    def _even(self, at: SurfaceCoordinates) -> SurfacePoints:
        """Return points whose weights are equal within each smooth part and sum to its area."""
        x, normal, _ = self.area_normals(at)
        part = self._parts[at.element]
        areas = np.bincount(self._parts, weights=self.element_areas)
        number = np.maximum(np.bincount(part, minlength=len(areas)), 1)
        weight = (self.area * (areas / areas.sum()) / number)[part]
        return SurfacePoints(at, x, normal, weight)

    def locate(
        self, x: Floats, direction: Floats, reach: float, tolerance: float = TOLERANCE
    ) -> Location:
        """Locate points x (m) along unit directions, (n, dim) each, up to a distance ``reach`` (m).

        Of several hits the nearest along the direction is chosen, then the one whose normal is
        closest to the direction, as at a corner, then the lowest element; of several misses the
        smallest. A point is missed if its line passes farther than ``tolerance`` local mesh sizes.
        """
        n = len(x)
        at = SurfaceCoordinates(np.full(n, -1, dtype=np.int64), np.zeros((n, self.dim - 1)))
        missed = np.full(n, Status.MISSED, dtype=np.int8)
        out = Location(at, np.full(n, np.nan), missed, tolerance)
        for rows in chunks(n, _PER_POINT):
            point, element, xi = self.candidates(x[rows], direction[rows], reach)
            point = point + rows.start
            aim = direction[point]
            xi, distance, miss = self._newton(element, xi, x[point], aim, tolerance)
            relative = miss / self.sizes[element]
            hit = (relative <= tolerance) & (np.abs(distance) <= reach)
            # Order: hits before misses; hits by distance, then by 1 - cosine of line and normal,
            # rounded so that elements tie at a shared edge and where they join smoothly.
            rank = np.where(hit, np.round(np.abs(distance) / reach, 10), relative)
            several = np.flatnonzero(hit & (np.bincount(point, hit)[point] > 1))
            flat = np.zeros(len(hit))
            normal = cross(self.tangents(element[several], xi[several])[1])
            length = np.linalg.norm(normal, axis=1)
            along = np.einsum("ni,ni->n", normal, aim[several])
            flat[several] = np.round(1 - np.abs(along) / np.where(length > 0, length, 1.0), 6)
            order = np.lexsort((element, flat, rank, ~hit, point))
            found, first = np.unique(point[order], return_index=True)
            best = order[first]
            at.element[found], at.xi[found] = element[best], xi[best]
            out.distance[found] = distance[best]
            edge = self.on_edge(element[best], xi[best], 10 * tolerance)
            inside = np.where(edge, Status.EDGE, Status.INSIDE)
            out.status[found] = np.where(hit[best], inside, Status.MISSED)
        return out

    def _newton(
        self, element: Ints, xi: Floats, x: Floats, direction: Floats, tolerance: float
    ) -> tuple[Floats, Floats, Floats]:
        """Return xi clamped to elements, distances along lines, and those by which lines miss.

        All pairs are iterated at once; pairs whose xi no longer changes leave the iteration.
        """
        xi = self.clamp(element, xi)
        offset = np.empty(x.shape)
        active = np.arange(len(element))
        for _ in range(_MAX_ITERATIONS):
            if not active.size:
                break
            e, before = element[active], xi[active]
            position, tangents = self.tangents(e, before)
            rest = x[active] - position
            xi[active] = self.clamp(e, before + newton_step(tangents, direction[active], rest))
            way = xi[active] - before
            # The last steps are so short that a linear update of the position is accurate.
            offset[active] = np.einsum("nij,nj->ni", tangents, way) - rest
            active = active[np.abs(way).max(axis=1) > 1e-3 * tolerance]
        if active.size:
            offset[active] = self.tangents(element[active], xi[active])[0] - x[active]
        distance, miss = apart(offset, direction)
        return xi, distance, miss

    def candidates(self, x: Floats, direction: Floats, reach: float) -> tuple[Ints, Ints, Floats]:
        """Return points, elements and initial xi of pairs that include every hit."""
        bounds = self.bounds
        # Margin for rounding, since the reach may be zero.
        room = reach + 1e-6 * 2 * float(bounds.radius.max())
        point, cell = near_boxes(bounds.low, bounds.high, x, room)
        along, across = apart(bounds.centre[cell] - x[point], direction[point])
        near = _NEAR * bounds.radius[cell]
        tried = (across <= near) & (np.abs(along) <= reach + near)
        point, cell = point[tried], cell[tried]
        offset = bounds.samples[cell] - x[point][:, None]
        along, across = apart(offset, direction[point][:, None])
        best = np.hypot(across, np.maximum(np.abs(along) - reach, 0.0)).argmin(axis=1)
        return point, bounds.element[cell], bounds.starts[cell, best]

    @cached_property
    def bounds(self) -> CellBounds:
        """Bounding boxes and spheres of the cells."""
        return CellBounds(self.cells, self.tangents)

    def clamp(self, element: Ints, xi: Floats) -> Floats:
        """Return the reference coordinates in the element nearest to xi, (n, dim - 1)."""
        if self.cells.tensor:
            low, high = self.domains
            return np.clip(xi, low[element], high[element])
        inside = np.maximum(xi, 0.0)
        along = np.clip((1 + xi[:, 0] - xi[:, 1]) / 2, 0.0, 1.0)
        slanted = np.column_stack([along, 1 - along])
        return np.where(inside.sum(axis=1, keepdims=True) > 1, slanted, inside)

    def on_edge(self, element: Ints, xi: Floats, tolerance: float) -> NDArray[np.bool_]:
        """Return whether xi is within ``tolerance``, relative to its range, of the cell's edges."""
        low, high = (ends[element] for ends in self.domains)
        t = (xi - low) / (high - low)
        far = 1 - (t.max(axis=1) if self.cells.tensor else t.sum(axis=1))
        return np.minimum(t.min(axis=1), far) <= tolerance
