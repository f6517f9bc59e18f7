"""Named surface of a Lagrange body: point rules, location of points, trace and gradient."""

from functools import cached_property

import basix
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints
from cea.location import cross
from cea.surface import Surface, TrueSurface
from cea.surface_points import SurfaceCells, SurfaceCoordinates, SurfacePoints
from fe_cea.corners import smooth_pairs
from fe_cea.facets import FacetLayer
from fe_cea.sagitta import sagittas

_OUTLINES = {
    basix.CellType.interval: np.array([[0.0], [1.0]]),
    basix.CellType.triangle: np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    basix.CellType.quadrilateral: np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
}
"""Corners of the reference facets in cyclic order."""


class FESurface(Surface):
    """Surface of a Lagrange body.

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

    abscissa_kinds = ("nodes",)
    abscissa_weights = ("equal", "tributary")

    def __init__(
        self,
        name: str,
        layer: FacetLayer,
        num_scalar_dofs: int,
        true: TrueSurface | None = None,
    ) -> None:
        super().__init__(name, num_scalar_dofs, true)
        self._layer = layer
        self._facet = layer.geometry.facet.cell_type

    @cached_property
    def domains(self) -> tuple[Floats, Floats]:
        """The unit interval, triangle or square of each facet."""
        shape = (len(self._layer), self._layer.dim - 1)
        return np.zeros(shape), np.ones(shape)

    @cached_property
    def _cells(self) -> SurfaceCells:
        outline = _OUTLINES[self._facet]
        corners = np.broadcast_to(outline, (len(self._layer), *outline.shape))
        tensor = self._facet != basix.CellType.triangle
        degree = self._layer.trace.cell.degree
        return SurfaceCells(np.arange(len(self._layer)), corners, degree, tensor)

    def cells(self) -> SurfaceCells:
        """The facets."""
        return self._cells

    @cached_property
    def element_areas(self) -> Floats:
        """Area (m^2; length in 2D) of each facet."""
        return self._area_points.weight.reshape(len(self._layer), -1).sum(axis=1)

    @property
    def _area_points(self) -> SurfacePoints:
        """Gauss points for the area, on flat facets exact for squares of traces too."""
        return self.gauss_points(
            self._layer.geometry.cell.degree + max(3, self._layer.trace.cell.degree)
        )

    @cached_property
    def _sizes(self) -> Floats:
        """Largest distance between nodes of each facet (m), (n_facets,)."""
        nodes = self._layer.facet_nodes
        return np.linalg.norm(nodes[:, :, None] - nodes[:, None, :], axis=3).max(axis=(1, 2))

    def size(self, element: Ints) -> Floats:
        """Diameter (m) of each facet, (n,)."""
        return self._sizes[element]

    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        return self._layer.tangents(element, xi)

    def area_normals(self, at: SurfaceCoordinates) -> tuple[Floats, Floats, Floats]:
        """Positions, outward unit normals, and area per area of xi."""
        x, tangents = self._layer.tangents(at.element, at.xi)
        normal = self._layer.orientation[at.element, None] * cross(tangents)
        area = np.linalg.norm(normal, axis=1)
        return x, normal / area[:, None], area

    @property
    def function_dofs(self) -> Ints:
        """Scalar dofs of the nodes of each facet, facet by facet."""
        return self._layer.facet_dofs.ravel()

    def function_points(self, kind: str) -> SurfaceCoordinates:
        """Interpolation nodes of every facet, facet by facet."""
        points, n = self._layer.trace.facet.points, len(self._layer)
        return SurfaceCoordinates(np.repeat(np.arange(n), len(points)), np.tile(points, (n, 1)))

    def values(self, at: SurfaceCoordinates, columns: Ints, count: int) -> csr_array:
        """Values of the functions of the nodes of facets; all others vanish there."""
        numbers = columns.reshape(self._layer.facet_dofs.shape)[at.element]
        return self._rows(self._layer.trace_values(at.xi), numbers, count)

    def gradient(self, at: SurfaceCoordinates) -> tuple[csr_array, ...]:
        """Derivatives of the scalar basis functions along x, y, z, each (n, num_scalar_dofs)."""
        columns = self._layer.dofs[self.known(at)]
        gradients = self._layer.gradients(at.element, at.xi)
        return tuple(self._rows(g, columns, self.num_scalar_dofs) for g in gradients)

    def _rows(self, values: Floats, columns: Ints, count: int) -> csr_array:
        n, per_row = values.shape
        starts = np.arange(0, n * per_row + 1, per_row)
        entries = (values.ravel(), columns.ravel().copy(), starts)  # put in order in place
        rows = csr_array(entries, shape=(n, count))
        rows.sort_indices()
        return rows

    def join_smoothly(self, at: SurfaceCoordinates, pairs: Ints) -> NDArray[np.bool_]:
        """Whether the facets of pairs of points join smoothly."""
        n = len(self._layer)
        one, other = np.sort(at.element[pairs], axis=1).T
        return np.isin(one * n + other, self._smooth_pairs @ np.array([n, 1]))

    @cached_property
    def _smooth_pairs(self) -> Ints:
        """Pairs of facets that join smoothly, (n, 2)."""
        dofs = self._layer.facet_dofs
        normals = self.normal(self.function_points("nodes")).reshape(*dofs.shape, self.dim)
        on_side = 1 if self.dim == 2 else self._layer.trace.cell.degree + 1
        return smooth_pairs(dofs, normals, on_side)

    def shares(self) -> Floats:
        """Each facet's area shared among its nodes in proportion to int N_i^2.

        As Hinton, Rock & Zienkiewicz 1976 lump a mass: positive where integrals of N_i are not.
        """
        points = self._area_points
        n = len(points) // len(self._layer)
        squares = self._layer.trace_values(points.at.xi[:n]) ** 2
        measure = points.weight.reshape(-1, n)
        parts = measure @ squares
        parts *= (measure.sum(axis=1) / parts.sum(axis=1))[:, None]
        return np.bincount(self.functions, weights=parts.ravel())

    def geometry_error(self, at: SurfaceCoordinates) -> Floats:
        """Estimated distance (m) of the true surface from facets where it is not known, (n,)."""
        if self._true is not None:
            return np.zeros(len(at))
        return self._sagittas[self.known(at)]

    @cached_property
    def _sagittas(self) -> Floats:
        return sagittas(self._layer)
