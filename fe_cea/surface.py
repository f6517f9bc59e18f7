"""Named surface of a Lagrange body: its facets with one layer of cells behind them.

Geometry and dofs of that layer are replicated on every rank.
"""

from functools import cached_property
from typing import Any

import basix
import numpy as np
from dolfinx.fem import IntegralType, compute_integration_domains
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints, chunks
from cea.location import cross
from cea.surface import Surface, TrueSurface
from cea.surface_points import SurfaceCells, SurfaceCoordinates, SurfacePoints
from fe_cea.corners import smooth_pairs
from fe_cea.facets import FacetBasis, geometry_element, nodes_and_dofs, reference_facets
from fe_cea.sagitta import sagittas

_OUTLINES = {
    basix.CellType.interval: np.array([[0.0], [1.0]]),
    basix.CellType.triangle: np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    basix.CellType.quadrilateral: np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
}
"""Corners of the reference facets in cyclic order."""


class FESurface(Surface):
    """Surface of a Lagrange body.

    Where facets meet at an angle, a point on their common edge has the normal of the facet of its
    coordinates. A point shared by several facets of a smooth part is kept once, on the first facet;
    at a corner each smooth part has its own point.

    Facet coordinates xi are in the unit interval, triangle or square; the point is
    ``corner + edges xi`` of the local facet in the reference cell. A surface is constructed from a
    scalar Lagrange space V and boundary facets of this rank (dolfinx); this is collective.
    """

    abscissa_kinds = ("nodes",)
    abscissa_weights = ("equal", "tributary")

    def __init__(self, name: str, V: Any, facets: Ints, true: TrueSurface | None = None) -> None:
        super().__init__(name, V.dofmap.index_map.size_global, true)
        topology = V.mesh.topology
        tdim = topology.dim
        topology.create_connectivity(tdim - 1, tdim)
        topology.create_connectivity(tdim, tdim - 1)
        pairs = compute_integration_domains(
            IntegralType.exterior_facet, topology, np.asarray(facets, dtype=np.int32)
        )
        cells, local = np.reshape(pairs, (-1, 2)).T
        nodes, dofs, local = (
            np.concatenate(V.mesh.comm.allgather(part))
            for part in (*nodes_and_dofs(V, cells), local.astype(np.int64))
        )
        self._geometry = FacetBasis(geometry_element(V.mesh))
        self._trace = FacetBasis(V.ufl_element().basix_element)
        # Sorted by their midpoints, so that the order of facets does not depend on the partition.
        midpoint = self._on_facets(nodes, self._geometry, local).mean(axis=1)
        extent = np.ptp(midpoint, axis=0).max(initial=0) or 1.0
        order = np.lexsort(np.round(midpoint / extent, 9).T[::-1])
        # Of the cell behind each facet: geometry nodes (m), (n, n_geometry, dim), global scalar
        # dofs, (n, n_dofs), and the local number of the facet, (n,).
        self._nodes, self._dofs, self._local = nodes[order], dofs[order], local[order]
        self._facet_nodes = self._on_facets(self._nodes, self._geometry, self._local)
        self._facet_dofs = self._on_facets(self._dofs[..., None], self._trace, self._local)[..., 0]
        self._facet = self._geometry.facet.cell_type

    @staticmethod
    def _on_facets(of_cells: Any, basis: FacetBasis, local: Ints) -> Any:
        """Return data at the dofs of cells, (n, dofs, k), restricted to those of their facets."""
        return np.take_along_axis(of_cells, basis.closure[local][:, :, None], axis=1)

    @cached_property
    def domains(self) -> tuple[Floats, Floats]:
        """The unit interval, triangle or square of each facet."""
        shape = (len(self._local), self._nodes.shape[2] - 1)
        return np.zeros(shape), np.ones(shape)

    @cached_property
    def cells(self) -> SurfaceCells:
        """The facets."""
        outline = _OUTLINES[self._facet]
        corners = np.broadcast_to(outline, (self.num_elements, *outline.shape))
        tensor = self._facet != basix.CellType.triangle
        degree = self._trace.cell.degree
        return SurfaceCells(np.arange(self.num_elements), corners, degree, tensor)

    @cached_property
    def element_areas(self) -> Floats:
        """Area (m^2; length in 2D) of each facet."""
        return self._area_points.weight.reshape(self.num_elements, -1).sum(axis=1)

    @property
    def _area_points(self) -> SurfacePoints:
        """Gauss points for the area, exact on flat facets also for squares of traces."""
        return self.gauss_points(self._geometry.cell.degree + max(3, self._trace.cell.degree))

    @cached_property
    def sizes(self) -> Floats:
        """Diameter of each facet (m), the largest distance between its nodes, (n_facets,)."""
        nodes = self._facet_nodes
        return np.linalg.norm(nodes[:, :, None] - nodes[:, None, :], axis=3).max(axis=(1, 2))

    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Return positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        n, dim = len(element), self.dim
        x, dx = np.empty((n, dim)), np.empty((n, dim, dim - 1))
        for rows in chunks(n, 16 * dim * self._facet_nodes.shape[1]):
            table = self._geometry.facet.tabulate(1, xi[rows])[..., 0]
            both = table.transpose(1, 0, 2) @ self._facet_nodes[element[rows]]
            x[rows], dx[rows] = both[:, 0], both[:, 1:].swapaxes(1, 2)
        return x, dx

    @cached_property
    def _orientation(self) -> Floats:
        """Sign for which the cross product of a facet's tangents points outward, (n,)."""
        everywhere = np.arange(self.num_elements)
        centre = np.full((self.num_elements, self.dim - 1), 1 / self.dim)
        _, tangents = self.tangents(everywhere, centre)
        jacobian = self._cell_jacobian(everywhere, self._reference_points(everywhere, centre))
        outward = basix.cell.facet_outward_normals(self._geometry.cell.cell_type)[self._local]
        pushed = np.linalg.solve(jacobian.swapaxes(1, 2), outward[:, :, None])[:, :, 0]
        return np.sign(np.einsum("ni,ni->n", cross(tangents), pushed))

    def area_normals(self, at: SurfaceCoordinates) -> tuple[Floats, Floats, Floats]:
        """Return positions, outward unit normals, and area per area of xi."""
        x, tangents = self.tangents(at.element, at.xi)
        normal = self._orientation[at.element, None] * cross(tangents)
        area = np.linalg.norm(normal, axis=1)
        return x, normal / area[:, None], area

    @property
    def function_dofs(self) -> Ints:
        """Scalar dofs of the nodes of each facet, facet by facet."""
        return self._facet_dofs.ravel()

    def function_points(self, kind: str) -> SurfaceCoordinates:
        """Return the interpolation nodes of every facet, facet by facet."""
        return self.cells.coordinates(self._trace.facet.points)[0]

    def values(self, at: SurfaceCoordinates, columns: Ints, count: int) -> csr_array:
        """Return the values of facet functions; all other functions vanish there."""
        numbers = columns.reshape(self._facet_dofs.shape)[at.element]
        return self._rows(self._trace_values(at.xi), numbers, count)

    def _trace_values(self, xi: Floats) -> Floats:
        """Return the values of a facet's basis functions at facet coordinates, (n, n_dofs)."""
        return self._trace.facet.tabulate(0, xi)[0, :, :, 0]

    def gradient(self, at: SurfaceCoordinates) -> tuple[csr_array, ...]:
        """Return derivatives of the scalar basis along x, y, z, each (n, num_scalar_dofs)."""
        element, xi, n, dim = self.known(at), at.xi, len(at), self.dim
        columns = self._dofs[element]
        gradients = np.empty((dim, n, columns.shape[1]))
        per_point = 16 * (1 + dim) * (self._nodes.shape[1] + columns.shape[1])
        for rows in chunks(n, per_point):
            reference = self._reference_points(element[rows], xi[rows])
            inverse = np.linalg.inv(self._cell_jacobian(element[rows], reference))
            table = self._trace.cell.tabulate(1, reference)[1:, :, :, 0]
            gradients[:, rows] = np.einsum("jnk,nji->ink", table, inverse)
        return tuple(self._rows(g, columns, self.num_scalar_dofs) for g in gradients)

    def _reference_points(self, element: Ints, xi: Floats) -> Floats:
        """Return points of facets in their reference cells, (n, dim)."""
        corners, edges = reference_facets(self._geometry.cell.cell_type)
        local = self._local[element]
        return corners[local] + np.einsum("nij,nj->ni", edges[local], xi)

    def _cell_jacobian(self, element: Ints, reference: Floats) -> Floats:
        """Return derivatives dx_i/dX_j of the cell maps, (n, dim, dim)."""
        table = self._geometry.cell.tabulate(1, reference)[1:, :, :, 0]
        return np.einsum("jnk,nki->nij", table, self._nodes[element])

    def _rows(self, values: Floats, columns: Ints, count: int) -> csr_array:
        n, per_row = values.shape
        starts = np.arange(0, n * per_row + 1, per_row)
        entries = (values.ravel(), columns.ravel().copy(), starts)  # sorted in place below
        rows = csr_array(entries, shape=(n, count))
        rows.sort_indices()
        return rows

    def join_smoothly(self, at: SurfaceCoordinates, pairs: Ints) -> NDArray[np.bool_]:
        """Return whether the facets of pairs of points join smoothly."""
        n = self.num_elements
        one, other = np.sort(at.element[pairs], axis=1).T
        return np.isin(one * n + other, self._smooth_pairs @ np.array([n, 1]))

    @cached_property
    def _smooth_pairs(self) -> Ints:
        """Pairs of facets that join smoothly, (n, 2)."""
        dofs = self._facet_dofs
        normals = self.normal(self.function_points("nodes")).reshape(*dofs.shape, self.dim)
        on_side = 1 if self.dim == 2 else self._trace.cell.degree + 1
        return smooth_pairs(dofs, normals, on_side)

    def shares(self) -> Floats:
        """Return area weights: each facet's area is shared in proportion to int N_i^2.

        The lumping of Hinton, Rock & Zienkiewicz 1976: positive where integrals of N_i are not.
        """
        points = self._area_points
        n = len(points) // self.num_elements
        squares = self._trace_values(points.at.xi[:n]) ** 2
        measure = points.weight.reshape(-1, n)
        parts = measure @ squares
        parts *= (measure.sum(axis=1) / parts.sum(axis=1))[:, None]
        return np.bincount(self.functions, weights=parts.ravel())

    def geometry_error(self, at: SurfaceCoordinates) -> Floats:
        """Return the estimated distance (m) of facets from an unknown exact surface, (n,)."""
        if self._true is not None:
            return np.zeros(len(at))
        return self._sagittas[self.known(at)]

    @cached_property
    def _sagittas(self) -> Floats:
        corners, _ = self.cells.coordinates(basix.geometry(self._facet))
        normals = self.normal(corners).reshape(self.num_elements, -1, self.dim)
        return sagittas(self._facet, self._facet_nodes, self._facet_dofs, normals)
