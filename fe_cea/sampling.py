"""Lattices of points through every cell, joined to straight cells, for pictures and comparisons."""

from itertools import permutations, product
from typing import Any

import basix
import basix.ufl
import numpy as np
from dolfinx.fem import functionspace
from dolfinx.fem.petsc import interpolation_matrix
from scipy.sparse import csr_array, vstack

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.volume import VolumeCells, VolumeSample
from fe_cea.facets import geometry_element, slices


def sample_volume(V: Any, subdivisions: int) -> VolumeSample:
    """Sample a Lagrange space on a lattice of each cell, shared points once; on every rank whole.

    The points are the nodes of an equispaced Lagrange space of degree ``subdivisions``, which
    numbers them over all ranks.
    """
    if subdivisions < 1:
        raise InputError("subdivisions", subdivisions, "at least 1")
    mesh = V.mesh
    W, element = _equispaced(mesh, subdivisions)
    lattice, numbers = W.dofmap.list, W.dofmap.index_map
    owned = numbers.size_local

    # Every owned point, once, from the first cell that has it; the table is the same in all cells.
    node, first = np.unique(lattice.ravel(), return_index=True)
    first = first[node < owned]
    cell, k = np.divmod(first, lattice.shape[1])
    table = V.ufl_element().basix_element.tabulate(0, element.points)[0, :, :, 0]
    dofs = V.dofmap.list
    columns = V.dofmap.index_map.local_to_global(dofs.ravel()).reshape(dofs.shape)[cell]
    starts = np.arange(0, columns.size + 1, columns.shape[1])
    values = csr_array(
        (table[k].ravel(), columns.ravel().astype(np.int64), starts),
        shape=(owned, V.dofmap.index_map.size_global),
    )
    values.eliminate_zeros()
    points = W.tabulate_dof_coordinates()[:, : mesh.geometry.dim]

    own_cells = lattice[: mesh.topology.index_map(mesh.topology.dim).size_local]
    split = own_cells[:, _subcells(element, subdivisions)]
    split = _right_handed(split.reshape(-1, split.shape[2]), points)
    cells = numbers.local_to_global(split.ravel()).reshape(split.shape).astype(np.int64)
    return VolumeSample(
        points=np.concatenate(mesh.comm.allgather(points[:owned])),
        cells=np.concatenate(mesh.comm.allgather(cells)),
        values=csr_array(vstack(mesh.comm.allgather(values), format="csr")),
    )


def lagrange_cells(V: Any) -> VolumeCells:
    """Cells of a Lagrange space on equally spaced nodes, shared nodes once; on every rank whole.

    Their degree is the higher one of space and geometry, so that both are held exactly.
    """
    mesh, dim = V.mesh, V.mesh.geometry.dim
    degree = max(V.ufl_element().degree, geometry_element(mesh).degree)
    W, element = _equispaced(mesh, degree)
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
    """Values of the scalar functions of V at the owned nodes of W, global numbers as columns."""
    matrix = interpolation_matrix(V, W)
    matrix.assemble()
    indptr, indices, data = matrix.getValuesCSR()
    matrix.destroy()
    shape = (len(indptr) - 1, V.dofmap.index_map.size_global)
    values = csr_array((data, indices.astype(np.int64), indptr), shape=shape)
    values.eliminate_zeros()
    return values


def _in_right_handed_order(cells: Ints, lattice: Ints, points: Floats) -> Ints:
    """Cells in C order of their lattice, those of negative volume with x and y exchanged."""
    dim, degree = lattice.shape[1], lattice.max()
    corners = degree * np.vstack([np.zeros(dim, dtype=int), np.eye(dim, dtype=int)])
    at = [int(np.flatnonzero((lattice == corner).all(axis=1))[0]) for corner in corners]
    edges = points[cells[:, at[1:]]] - points[cells[:, at[:1]]]
    exchanged = np.lexsort(lattice[:, [1, 0, *range(2, dim)]].T[::-1])
    return np.where(np.linalg.det(edges)[:, None] < 0, cells[:, exchanged], cells)


def _equispaced(mesh: Any, degree: int) -> tuple[Any, Any]:
    """Lagrange space on equally spaced nodes (dolfinx), and its element (basix)."""
    element = basix.ufl.element(
        "Lagrange",
        mesh.basix_cell(),
        degree,
        lagrange_variant=basix.LagrangeVariant.equispaced,
    )
    return functionspace(mesh, element), element.basix_element


def cell_jacobians(mesh: Any) -> Floats:
    """Jacobian determinants (m^dim) at Gauss points of the cells of this rank, (cells, points)."""
    element = geometry_element(mesh)
    points, _ = basix.make_quadrature(mesh.basix_cell(), 2 * element.degree + 1)
    slopes = element.tabulate(1, points)[1:, :, :, 0]
    owned = mesh.topology.index_map(mesh.topology.dim).size_local
    out = np.empty((owned, len(points)))
    for rows in slices(owned, 16 * mesh.geometry.dim**2 * len(points)):
        nodes = mesh.geometry.x[mesh.geometry.dofmaps[0][rows], : mesh.geometry.dim]
        out[rows] = np.linalg.det(np.einsum("jqk,cki->cqij", slopes, nodes, optimize=True))
    return out


def _subcells(element: Any, subdivisions: int) -> Ints:
    """Lattice cells of one reference cell, as numbers of lattice nodes in VTK order."""
    lattice = np.rint(element.points * subdivisions).astype(int)
    dim = lattice.shape[1]
    if element.cell_type in (basix.CellType.triangle, basix.CellType.tetrahedron):
        corners = _simplices(dim, subdivisions)
    else:
        corners = _boxes(dim, subdivisions)
    node = np.full((subdivisions + 1,) * dim, -1, dtype=np.int64)
    node[tuple(lattice.T)] = np.arange(len(lattice))
    return node[tuple(np.moveaxis(corners, -1, 0))]


def _right_handed(cells: Ints, points: Floats) -> Ints:
    """Cells in VTK order, those of negative volume mirrored."""
    dim, corners = points.shape[1], cells.shape[1]
    if corners == dim + 1:
        neighbours, mirrored = list(range(1, dim + 1)), [*range(dim - 1), dim, dim - 1]
    else:
        neighbours = [1, 3, 4][:dim]
        mirrored = [0, 3, 2, 1, 4, 7, 6, 5][:corners]
    edges = points[cells[:, neighbours]] - points[cells[:, :1]]
    negative = np.linalg.det(edges) < 0
    return np.where(negative[:, None], cells[:, mirrored], cells)


def _boxes(dim: int, n: int) -> Ints:
    """Corners of the boxes of a lattice in VTK order, (n^dim, 2^dim, dim)."""
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    if dim == 3:
        square = np.vstack([np.insert(square, 2, z, axis=1) for z in (0, 1)])
    base = np.array(list(product(range(n), repeat=dim)))
    return base[:, None, :] + square


def _simplices(dim: int, n: int) -> Ints:
    """Corners of the simplices of a lattice, all of one size, (n^dim, dim + 1, dim).

    The sums a_i = X_i + ... + X_dim turn the reference simplex into a_1 >= ... >= a_dim, which
    holds whole simplices of the Kuhn division of each lattice cube.
    """
    base = np.array(list(product(range(n), repeat=dim)))
    steps = np.eye(dim, dtype=int)
    paths = [
        np.cumsum(np.vstack([np.zeros(dim, dtype=int), steps[list(order)]]), axis=0)
        for order in permutations(range(dim))
    ]
    sums = (base[:, None, None, :] + np.array(paths)).reshape(-1, dim + 1, dim)
    inside = (np.diff(sums, axis=2) <= 0).all(axis=(1, 2))
    following = np.concatenate([sums[..., 1:], np.zeros_like(sums[..., :1])], axis=2)
    return (sums - following)[inside]
