"""Named surface of a Lagrange body: point rules, location of points, trace and gradient."""

from dataclasses import replace
from functools import cached_property

import basix
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints
from cea.corners import connected, equal_shares, pairs_of_equal, smooth_parts, split_functions
from cea.errors import InputError
from cea.location import cross, locate_along
from cea.surface import (
    Location,
    SurfaceCells,
    SurfaceCoordinates,
    SurfacePoints,
    TrueSurface,
)
from fe_cea.corners import smooth_pairs
from fe_cea.facets import FacetLayer
from fe_cea.sagitta import sagittas
from fe_cea.search import FacetBounds

_MERGE = 1e-7
"""Grid points nearer than this, relative to the spacing of the smallest facet, are one."""

_OUTLINES = {
    basix.CellType.interval: np.array([[0.0], [1.0]]),
    basix.CellType.triangle: np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    basix.CellType.quadrilateral: np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
}
"""Corners of the reference facets in cyclic order."""


class FESurface:
    """Surface of a Lagrange body; also the chart that point location works on.

    Where facets meet at an angle, a point on their common edge has the normal of the facet whose
    coordinates it bears. Of points that several facets of a smooth part share there is one, on the
    first facet; at a corner each smooth part has its own.

    Parameters
    ----------
    name
        Name of the surface.
    layer
        Its facets with the cells behind them.
    num_scalar_dofs
        Scalar dofs of the body.
    true
        The surface that the facets interpolate; None where it is not known.
    """

    def __init__(
        self,
        name: str,
        layer: FacetLayer,
        num_scalar_dofs: int,
        true: TrueSurface | None = None,
    ) -> None:
        self._name = name
        self._layer = layer
        self._num_scalar_dofs = num_scalar_dofs
        self._true = true
        self._facet = layer.geometry.facet.cell_type
        self._is_triangle = self._facet == basix.CellType.triangle

    @property
    def name(self) -> str:
        """Name of the surface."""
        return self._name

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""
        return self._layer.dim

    @property
    def num_scalar_dofs(self) -> int:
        """Scalar dofs of the body: columns of the trace."""
        return self._num_scalar_dofs

    @property
    def abscissa_kinds(self) -> tuple[str, ...]:
        """Kinds of abscissae: interpolation nodes."""
        return ("nodes",)

    @property
    def abscissa_weights(self) -> tuple[str, ...]:
        """Kinds of weights of abscissae."""
        return ("equal", "tributary")

    @property
    def num_elements(self) -> int:
        """Number of its facets."""
        return len(self._layer)

    @cached_property
    def area(self) -> float:
        """Area (m^2; length in 2D) of the meshed surface."""
        return float(self._area_points.weight.sum())

    @property
    def _area_points(self) -> SurfacePoints:
        """Gauss points for the area, on flat facets exact for squares of traces too."""
        return self.gauss_points(
            self._layer.geometry.cell.degree + max(3, self._layer.trace.cell.degree)
        )

    @cached_property
    def mesh_size(self) -> float:
        """Largest diameter of its facets (m)."""
        return float(self._sizes.max())

    @cached_property
    def _sizes(self) -> Floats:
        """Largest distance between nodes of each facet (m), (n_facets,)."""
        nodes = self._layer.facet_nodes
        return np.linalg.norm(nodes[:, :, None] - nodes[:, None, :], axis=3).max(axis=(1, 2))

    def cells(self) -> SurfaceCells:
        """The facets."""
        outline = _OUTLINES[self._facet]
        corners = np.broadcast_to(outline, (len(self._layer), *outline.shape))
        degree = self._layer.trace.cell.degree
        return SurfaceCells(np.arange(len(self._layer)), corners, degree, not self._is_triangle)

    def gauss_points(self, n: int) -> SurfacePoints:
        """Gauss points, n per direction in each facet, weights with the Jacobian.

        On triangles the collapsed product of Gauss-Legendre and Gauss-Jacobi points, exact to
        degree 2n - 1 as on squares.

        Raises
        ------
        InputError
            When n is less than 1.
        """
        if n < 1:
            raise InputError("n", n, "at least 1 Gauss point per direction")
        xi, weights = basix.make_quadrature(
            self._facet, 2 * n - 1, basix.QuadratureType.gauss_jacobi
        )
        at = self._on_every_facet(xi)
        x, tangents = self._layer.tangents(at.element, at.xi)
        normal = self._layer.orientation[at.element, None] * cross(tangents)
        jacobian = np.linalg.norm(normal, axis=1)
        weight = np.tile(weights, len(self._layer)) * jacobian
        return SurfacePoints(at, x, normal / jacobian[:, None], weight)

    def abscissae(self, kind: str, weights: str = "equal") -> SurfacePoints:
        """Interpolation nodes of the trace space, at a corner once for each smooth part.

        Parameters
        ----------
        kind
            ``nodes``.
        weights
            ``equal``: even shares of the area of each smooth part. ``tributary``: each facet's
            area shared among its nodes in proportion to int N_i^2 (as Hinton, Rock & Zienkiewicz
            1976 lump a mass), positive where integrals of N_i are not, and added up to the area.

        Raises
        ------
        InputError
            For another kind of abscissae or weights.
        """
        if kind not in self.abscissa_kinds:
            raise InputError("abscissae", kind, f"one of {', '.join(self.abscissa_kinds)}")
        if weights not in self.abscissa_weights:
            raise InputError("weights", weights, f"one of {', '.join(self.abscissa_weights)}")
        functions = self._functions.ravel()
        first = np.sort(np.unique(functions, return_index=True)[1])
        points = self._equal_weights(self._nodes[first])
        if weights == "equal":
            return points
        shares = np.bincount(functions, weights=self._shares.ravel())
        return replace(points, weight=shares[functions[first]])

    @property
    def _nodes(self) -> SurfaceCoordinates:
        """Interpolation nodes of every facet, facet by facet."""
        return self._on_every_facet(self._layer.trace.facet.points)

    @cached_property
    def _functions(self) -> Ints:
        """Numbers of the trace functions split at corners, of each facet, (n_facets, n_nodes)."""
        dofs = self._layer.facet_dofs
        pairs = pairs_of_equal(dofs.ravel())
        groups = connected(pairs[self._join(pairs // dofs.shape[1])], dofs.size)
        return split_functions(dofs.ravel(), groups, self._num_scalar_dofs).reshape(dofs.shape)

    def _join(self, facets: Ints) -> NDArray[np.bool_]:
        """Whether pairs of facets, (n, 2), join smoothly."""
        n = len(self._layer)
        one, other = np.sort(facets, axis=1).T
        return np.isin(one * n + other, self._smooth_pairs @ np.array([n, 1]))

    @cached_property
    def _smooth_pairs(self) -> Ints:
        """Pairs of facets that join smoothly, (n, 2)."""
        dofs = self._layer.facet_dofs
        normals = self.normal(self._nodes).reshape(*dofs.shape, self.dim)
        on_side = 1 if self.dim == 2 else self._layer.trace.cell.degree + 1
        return smooth_pairs(dofs, normals, on_side)

    @cached_property
    def _parts(self) -> Ints:
        """Smooth part of each facet, (n_facets,)."""
        facets = np.repeat(np.arange(len(self._layer)), self._functions.shape[1])
        return smooth_parts(facets, self._functions.ravel(), len(self._layer))

    @property
    def _shares(self) -> Floats:
        """Part of its area (m^2) that each facet gives each of its nodes, (n_facets, n_nodes)."""
        points = self._area_points
        n = len(points) // len(self._layer)
        squares = self._layer.trace_values(points.at.xi[:n]) ** 2
        measure = points.weight.reshape(-1, n)
        shares = measure @ squares
        return shares * (measure.sum(axis=1) / shares.sum(axis=1))[:, None]

    def grid(self, n: int) -> SurfacePoints:
        """Equally spaced points, n per side of each facet, shared ones once in a smooth part.

        The area of each smooth part is shared evenly among its points.

        Raises
        ------
        InputError
            When n is less than 2.
        """
        if n < 2:
            raise InputError("n", n, "at least 2 grid points per side, the ends")
        lattice = basix.create_lattice(self._facet, n - 1, basix.LatticeType.equispaced, True)
        at = self._on_every_facet(lattice)
        tree = cKDTree(self.position(at))
        twins = tree.query_pairs(_MERGE * self._sizes.min() / (n - 1), output_type="ndarray")
        groups = connected(twins[self._join(at.element[twins])], len(at))
        return self._equal_weights(at[np.sort(np.unique(groups, return_index=True)[1])])

    def _on_every_facet(self, xi: Floats) -> SurfaceCoordinates:
        """The same facet coordinates on every facet, facet by facet."""
        n = len(self._layer)
        return SurfaceCoordinates(np.repeat(np.arange(n), len(xi)), np.tile(xi, (n, 1)))

    def _equal_weights(self, at: SurfaceCoordinates) -> SurfacePoints:
        area = self._area_points
        areas = np.bincount(self._parts[area.at.element], weights=area.weight)
        weight = equal_shares(self._parts[at.element], areas, self.area)
        return SurfacePoints(at, self.position(at), self.normal(at), weight)

    def position(self, at: SurfaceCoordinates) -> Floats:
        """Positions (m), shape (n, dim)."""
        return self._layer.tangents(self._known(at), at.xi)[0]

    def normal(self, at: SurfaceCoordinates) -> Floats:
        """Outward unit normals, shape (n, dim)."""
        _, tangents = self._layer.tangents(self._known(at), at.xi)
        normal = self._layer.orientation[at.element, None] * cross(tangents)
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def offset(self, at: SurfaceCoordinates, direction: Floats) -> Floats:
        """Signed distance (m) from facets to the true surface along unit directions, shape (n,).

        Zero where the true surface is not known.
        """
        if self._true is None:
            return np.zeros(len(at))
        return self._true.distance(self.position(at), direction)

    def normal_error(self, at: SurfaceCoordinates) -> Floats:
        """Normals of the facets less those of the true surface, shape (n, dim); zero likewise."""
        normal = self.normal(at)
        if self._true is None:
            return np.zeros_like(normal)
        return normal - self._true.normal(self.position(at), normal)

    def geometry_error(self, at: SurfaceCoordinates) -> Floats:
        """Estimated distance (m) of the true surface from facets where it is not known, (n,)."""
        if self._true is not None:
            return np.zeros(len(at))
        return self._sagittas[self._known(at)]

    @cached_property
    def _sagittas(self) -> Floats:
        return sagittas(self._layer)

    def trace(self, at: SurfaceCoordinates) -> csr_array:
        """Values of the scalar basis functions, shape (n, num_scalar_dofs).

        A row holds the functions of the nodes of its facet; all others vanish there.
        """
        return self._values(at, self._rising, self._num_scalar_dofs)

    @cached_property
    def _rising(self) -> tuple[Ints, Ints]:
        return _in_order(self._layer.facet_dofs)

    def split_trace(self, at: SurfaceCoordinates) -> csr_array:
        """The same of the functions split at corners, shape (n, num_scalar_dofs + further)."""
        count = max(self._num_scalar_dofs, int(self._functions.max(initial=0)) + 1)
        return self._values(at, _in_order(self._functions), count)

    def _values(self, at: SurfaceCoordinates, columns: tuple[Ints, Ints], count: int) -> csr_array:
        """Values of the functions of the nodes of facets, in their columns."""
        numbers, order = columns
        element = self._known(at)
        values = np.take_along_axis(self._layer.trace_values(at.xi), order[element], axis=1)
        return self._rows(values, numbers[element], count)

    def gradient(self, at: SurfaceCoordinates) -> tuple[csr_array, ...]:
        """Derivatives of the scalar basis functions along x, y, z, each (n, num_scalar_dofs)."""
        columns = self._layer.dofs[self._known(at)]
        gradients = self._layer.gradients(at.element, at.xi)
        return tuple(self._rows(g, columns, self._num_scalar_dofs) for g in gradients)

    def _rows(self, values: Floats, columns: Ints, count: int) -> csr_array:
        n, per_row = values.shape
        starts = np.arange(0, n * per_row + 1, per_row)
        return csr_array((values.ravel(), columns.ravel(), starts), shape=(n, count))

    def _known(self, at: SurfaceCoordinates) -> Ints:
        """Facets of points, once checked that each has one."""
        if len(at) and not 0 <= at.element.min() <= at.element.max() < len(self._layer):
            wrong = [at.element.min(), at.element.max()]
            raise InputError("at.element", wrong, f"0 to {len(self._layer) - 1}: points found")
        return at.element

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
        return locate_along(self, x, direction, reach)

    def candidates(self, x: Floats, direction: Floats, reach: float) -> tuple[Ints, Ints, Floats]:
        """Facets that the line through each point may meet, tried from their centres."""
        bounds = self._bounds
        point, element = bounds.within(x, reach)
        near = bounds.near_lines(point, element, x, direction, reach)
        point, element = point[near], element[near]
        return point, element, np.full((len(point), self.dim - 1), 1 / self.dim)

    @cached_property
    def _bounds(self) -> FacetBounds:
        return FacetBounds(self._layer)

    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        return self._layer.tangents(element, xi)

    def clamp(self, element: Ints, xi: Floats) -> Floats:
        """Nearest point of the unit interval, triangle or square, (n, dim - 1)."""
        if not self._is_triangle:
            return np.clip(xi, 0.0, 1.0)
        inside = np.maximum(xi, 0.0)
        along = np.clip((1 + xi[:, 0] - xi[:, 1]) / 2, 0.0, 1.0)
        slanted = np.column_stack([along, 1 - along])
        return np.where(inside.sum(axis=1, keepdims=True) > 1, slanted, inside)

    def on_edge(self, element: Ints, xi: Floats, tolerance: float) -> np.ndarray:
        """True where xi lies on the boundary of the facet, within a reference tolerance."""
        far = 1 - xi.sum(axis=1) if self._is_triangle else 1 - xi.max(axis=1)
        return np.minimum(xi.min(axis=1), far) <= tolerance

    def size(self, element: Ints) -> Floats:
        """Diameter (m) of each facet, (n,)."""
        return self._sizes[element]


def _in_order(numbers: Ints) -> tuple[Ints, Ints]:
    """Numbers of the functions of each facet, rising, and their places in it."""
    order = np.argsort(numbers, axis=1)
    return np.take_along_axis(numbers, order, axis=1), order
