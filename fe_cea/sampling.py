"""Cells of a Lagrange space for visualisation, on every rank, and their Jacobians."""

from typing import Any

import basix
import basix.ufl
import numpy as np
from dolfinx.fem import functionspace
from dolfinx.fem.petsc import interpolation_matrix
from scipy.sparse import csr_array, vstack

from cea.arrays import Floats, Ints, chunks
from cea.body import VolumeCells
from cea.errors import require
from fe_cea.facets import geometry_element

_FLAT = 1e-10
"""Smallest Jacobian of a cell, relative to its largest, below which the cell is inverted."""


def lagrange_cells(V: Any) -> VolumeCells:
    """Return cells of a Lagrange space on equally spaced nodes, complete on every rank.

    Their degree is the higher one of space and geometry, so that both are represented exactly.
    """
    mesh, dim = V.mesh, V.mesh.geometry.dim
    degree = max(V.ufl_element().degree, geometry_element(mesh).degree)
    kind = basix.LagrangeVariant.equispaced
    of_mesh = basix.ufl.element("Lagrange", mesh.basix_cell(), degree, lagrange_variant=kind)
    W, element = functionspace(mesh, of_mesh), of_mesh.basix_element
    numbers = W.dofmap.index_map
    points = W.tabulate_dof_coordinates()[:, :dim]

    owned = mesh.topology.index_map(mesh.topology.dim).size_local
    lattice = np.rint(element.points * degree).astype(int)
    c_order = np.lexsort(lattice.T[::-1])
    simplex = element.cell_type in (basix.CellType.triangle, basix.CellType.tetrahedron)
    cells = _in_right_handed_order(W.dofmap.list[:owned][:, c_order], lattice[c_order], points)
    cells = numbers.local_to_global(cells.ravel()).reshape(cells.shape).astype(np.int64)

    gathered = np.concatenate(mesh.comm.allgather(points[: numbers.size_local]))
    return VolumeCells(
        kind="lagrange",
        simplex=simplex,
        degree=degree,
        points=gathered,
        weights=np.ones(len(gathered)),
        cells=np.concatenate(mesh.comm.allgather(cells)),
        values=csr_array(vstack(mesh.comm.allgather(_values(V, W)), format="csr")),
    )


def _values(V: Any, W: Any) -> csr_array:
    """Return the scalar functions of V at the owned nodes of W; columns are global dofs."""
    matrix = interpolation_matrix(V, W)
    matrix.assemble()
    indptr, indices, data = matrix.getValuesCSR()
    matrix.destroy()
    shape = (len(indptr) - 1, V.dofmap.index_map.size_global)
    values = csr_array((data, indices.astype(np.int64), indptr), shape=shape)
    values.eliminate_zeros()
    return values


def _in_right_handed_order(cells: Ints, lattice: Ints, points: Floats) -> Ints:
    """Return cells with positive volume: x and y are exchanged in those of negative volume."""
    dim, degree = lattice.shape[1], lattice.max()
    corners = degree * np.vstack([np.zeros(dim, dtype=int), np.eye(dim, dtype=int)])
    at = [int(np.flatnonzero((lattice == corner).all(axis=1))[0]) for corner in corners]
    edges = points[cells[:, at[1:]]] - points[cells[:, at[:1]]]
    exchanged = np.lexsort(lattice[:, [1, 0, *range(2, dim)]].T[::-1])
    return np.where(np.linalg.det(edges)[:, None] < 0, cells[:, exchanged], cells)


def check_jacobians(mesh: Any, field: str) -> None:
    """Raise InputError if the Jacobian of a cell of this rank changes sign or vanishes."""
    element = geometry_element(mesh)
    points, _ = basix.make_quadrature(mesh.basix_cell(), 2 * element.degree + 1)
    slopes = element.tabulate(1, points)[1:, :, :, 0]
    owned = mesh.topology.index_map(mesh.topology.dim).size_local
    jacobians = np.empty((owned, len(points)))
    for rows in chunks(owned, 16 * mesh.geometry.dim**2 * len(points)):
        nodes = mesh.geometry.x[mesh.geometry.dofmaps[0][rows], : mesh.geometry.dim]
        jacobians[rows] = np.linalg.det(np.einsum("jqk,cki->cqij", slopes, nodes, optimize=True))
    turned = np.sign(jacobians[:, :1]) * jacobians
    inverted = ~(turned.min(axis=1) > _FLAT * np.abs(jacobians).max(axis=1))
    allowed = "cells whose Jacobian keeps its sign: some are inverted or flat"
    require(not inverted.any(), field, f"{inverted.sum()} of {owned} cells", allowed)
