"""One layer of cells along a surface: geometry and dofs of its facets, replicated on every rank."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import basix
import numpy as np
from dolfinx.fem import IntegralType, compute_integration_domains

from cea.arrays import Floats, Ints, chunks
from cea.location import cross


@dataclass(frozen=True)
class FacetBasis:
    """A Lagrange element on a cell, and what it leaves on each facet of the cell."""

    cell: Any  # element on the reference cell (basix)

    @cached_property
    def facet(self) -> Any:
        """Element of the same degree on the reference facet (basix)."""
        kind = basix.cell.sub_entity_type(self.cell.cell_type, self._facet_dim, 0)
        return basix.create_element(
            self.cell.family, kind, self.cell.degree, self.cell.lagrange_variant
        )

    @cached_property
    def closure(self) -> Ints:
        """Cell dofs on each local facet in the order of the facet's dofs, (facets, n_dofs).

        Found by points: a Lagrange function of the cell is one at its own node only.
        """
        points = self.facet.points
        reference = [
            corner + points @ tangents.T
            for corner, tangents in zip(*reference_facets(self.cell.cell_type), strict=True)
        ]
        values = [self.cell.tabulate(0, x)[0, :, :, 0] for x in reference]
        return np.argmax(values, axis=2).astype(np.int64)

    @property
    def _facet_dim(self) -> int:
        return len(basix.topology(self.cell.cell_type)) - 2


def reference_facets(cell_type: Any) -> tuple[Floats, Floats]:
    """First corners (facets, dim) and edge vectors (facets, dim, dim - 1) of reference facets."""
    vertices = basix.topology(cell_type)[-2]
    corners = basix.geometry(cell_type)[[v[0] for v in vertices]]
    return corners, np.asarray(basix.cell.facet_jacobians(cell_type))


@dataclass(frozen=True)
class FacetLayer:
    """Facets of a surface with the cells behind them.

    Facet coordinates xi live on the unit interval, triangle or square; the point is
    ``corner + edges xi`` of the local facet in the reference cell.
    """

    # elements of the mesh geometry and of the scalar displacement
    geometry: FacetBasis
    trace: FacetBasis
    nodes: Floats  # geometry nodes (m) of the cell behind each facet, (n, n_geometry, dim)
    dofs: Ints  # global scalar dofs of that cell, (n, n_dofs)
    local: Ints  # number of the facet in its cell, (n,)

    def __len__(self) -> int:
        return len(self.local)

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return self.nodes.shape[2]

    @cached_property
    def facet_nodes(self) -> Floats:
        """Geometry nodes (m) of the facets, (n, n_nodes, dim)."""
        columns = self.geometry.closure[self.local]
        return np.take_along_axis(self.nodes, columns[:, :, None], axis=1)

    @cached_property
    def facet_dofs(self) -> Ints:
        """Global scalar dofs of the facets, (n, n_dofs)."""
        return np.take_along_axis(self.dofs, self.trace.closure[self.local], axis=1)

    @cached_property
    def orientation(self) -> Floats:
        """Sign that turns the cross product of a facet's tangents outward, (n,)."""
        everywhere = np.arange(len(self))
        centre = np.full((len(self), self.dim - 1), 1 / self.dim)
        _, tangents = self.tangents(everywhere, centre)
        reference = self._reference_points(everywhere, centre)
        jacobian = self._cell_jacobian(everywhere, reference)
        outward = basix.cell.facet_outward_normals(self.geometry.cell.cell_type)[self.local]
        pushed = np.linalg.solve(jacobian.swapaxes(1, 2), outward[:, :, None])[:, :, 0]
        return np.sign(np.einsum("ni,ni->n", cross(tangents), pushed))

    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Positions (m), (n, dim), and their derivatives along xi, (n, dim, dim - 1)."""
        n, dim = len(element), self.dim
        x, dx = np.empty((n, dim)), np.empty((n, dim, dim - 1))
        for rows in chunks(n, 16 * dim * self.facet_nodes.shape[1]):
            table = self.geometry.facet.tabulate(1, xi[rows])[..., 0]
            both = table.transpose(1, 0, 2) @ self.facet_nodes[element[rows]]
            x[rows], dx[rows] = both[:, 0], both[:, 1:].swapaxes(1, 2)
        return x, dx

    def trace_values(self, xi: Floats) -> Floats:
        """Values at facet coordinates of the basis functions of a facet, (n, n_dofs)."""
        return self.trace.facet.tabulate(0, xi)[0, :, :, 0]

    def gradients(self, element: Ints, xi: Floats) -> Floats:
        """Derivatives along x, y, z of every basis function of the cell, (dim, n, n_dofs), 1/m."""
        n, dim = len(element), self.dim
        out = np.empty((dim, n, self.dofs.shape[1]))
        per_point = 16 * (1 + dim) * (self.nodes.shape[1] + self.dofs.shape[1])
        for rows in chunks(n, per_point):
            reference = self._reference_points(element[rows], xi[rows])
            jacobian = self._cell_jacobian(element[rows], reference)
            table = self.trace.cell.tabulate(1, reference)[1:, :, :, 0]
            inverse = np.linalg.inv(jacobian)
            out[:, rows] = np.einsum("jnk,nji->ink", table, inverse)
        return out

    def _reference_points(self, element: Ints, xi: Floats) -> Floats:
        """Points of facets in their reference cells, (n, dim)."""
        corners, edges = reference_facets(self.geometry.cell.cell_type)
        local = self.local[element]
        return corners[local] + np.einsum("nij,nj->ni", edges[local], xi)

    def _cell_jacobian(self, element: Ints, reference: Floats) -> Floats:
        """Derivatives dx_i/dX_j of the cell maps, (n, dim, dim)."""
        table = self.geometry.cell.tabulate(1, reference)[1:, :, :, 0]
        return np.einsum("jnk,nki->nij", table, self.nodes[element])


def geometry_element(mesh: Any) -> Any:
    """Lagrange element (basix) of the geometry of a mesh (dolfinx)."""
    cmap = mesh.geometry.cmaps[0]
    return basix.create_element(
        basix.ElementFamily.P,
        mesh.basix_cell(),
        cmap.degree,
        basix.LagrangeVariant(cmap.variant),
    )


def nodes_and_dofs(V: Any, cells: Ints) -> tuple[Floats, Ints]:
    """Geometry nodes (m) and global scalar dofs of some cells of this rank, by cell."""
    geometry, blocks = V.mesh.geometry, V.dofmap.list[cells]
    dofs = V.dofmap.index_map.local_to_global(blocks.ravel()).reshape(blocks.shape)
    return geometry.x[geometry.dofmaps[0][cells], : geometry.dim], dofs.astype(np.int64)


def gather_facets(V: Any, facets: Ints) -> FacetLayer:
    """Collect the layer of cells behind boundary facets on every rank.

    Facets are sorted by their midpoints, so their order does not depend on the partition.
    """
    mesh = V.mesh
    tdim = mesh.topology.dim
    mesh.topology.create_connectivity(tdim - 1, tdim)
    mesh.topology.create_connectivity(tdim, tdim - 1)
    pairs = compute_integration_domains(
        IntegralType.exterior_facet, mesh.topology, np.asarray(facets, dtype=np.int32)
    )
    cells, local = np.reshape(pairs, (-1, 2)).T
    nodes, dofs, local = (
        np.concatenate(mesh.comm.allgather(part))
        for part in (*nodes_and_dofs(V, cells), local.astype(np.int64))
    )
    geometry = FacetBasis(geometry_element(mesh))
    trace = FacetBasis(V.ufl_element().basix_element)
    layer = FacetLayer(geometry, trace, nodes, dofs, local)
    midpoint = layer.facet_nodes.mean(axis=1)
    extent = np.ptp(midpoint, axis=0).max(initial=0) or 1.0
    order = np.lexsort(np.round(midpoint / extent, 9).T[::-1])
    return FacetLayer(geometry, trace, nodes[order], layer.dofs[order], local[order])
