"""Meshes of simplices made of meshes of boxes: each quadrilateral gives two, each hexahedron six.

The six tetrahedra of a hexahedron have the diagonal from its first to its last corner in common and
go along one direction after the other (H. W. Kuhn, IBM J. Res. Dev. 4, 1960). Neighbours divide
their common face alike when parallel edges run the same way through the whole mesh.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cea.errors import require
from cea.mesh import Ints, Mesh, lattice

_SIMPLEX = {"quadrilateral": "triangle", "hexahedron": "tetrahedron"}


def divided(mesh: Mesh) -> Mesh:
    """Divide quadrilaterals into two triangles, hexahedra into six tetrahedra, on the same nodes.

    Parameters
    ----------
    mesh
        Mesh of quadrilaterals or hexahedra; its surfaces are divided with it.

    Raises
    ------
    InputError
        When cells are simplices already, or hexahedra are put together so that edges cannot run
        the same way through the mesh (as around a Moebius strip).
    """
    require(mesh.cell in _SIMPLEX, "cell", mesh.cell, f"one of {', '.join(_SIMPLEX)}")
    order, points = mesh.order, mesh.points
    if mesh.cell == "quadrilateral":
        return Mesh("triangle", order, points, _split(mesh.cells, 2, order), mesh.surfaces)
    aligned = replace(mesh, cells=_same_ways(mesh))  # its facets run as their cells do
    facets = {name: _split(part, 2, order) for name, part in aligned.surfaces.items()}
    return Mesh("tetrahedron", order, points, _split(aligned.cells, 3, order), facets)


def _split(boxes: Ints, dim: int, order: int) -> Ints:
    """Nodes of the simplices of boxes, those of one box after another, (n_simplices, n_nodes)."""
    places = lattice(dim, order, simplex=True)
    parts = [
        np.ravel_multi_index((places @ _edges(way)).T, (order + 1,) * dim)
        for way in permutations(range(dim))
    ]
    return boxes[:, parts].reshape(-1, len(places))


def _edges(way: Sequence[int]) -> Ints:
    """Edges from the first corner of a simplex to the others, right-handed, (dim, dim)."""
    corners = np.cumsum(np.eye(len(way), dtype=np.int64)[list(way)], axis=0)
    if np.linalg.det(corners) < 0:
        corners[[0, 1]] = corners[[1, 0]]
    return corners


def _same_ways(mesh: Mesh) -> Ints:
    """Cells of hexahedra, some turned over so that parallel edges run the same way in all."""
    order = mesh.order
    nodes = mesh.cells.reshape(-1, *(order + 1,) * 3)
    against = _against(nodes[:, ::order, ::order, ::order])
    for axis in range(3):
        flip = against[:, axis, None, None, None]
        nodes = np.where(flip, np.flip(nodes, axis=axis + 1), nodes)
    return nodes.reshape(mesh.cells.shape)


def _against(corners: Ints) -> NDArray[np.bool_]:
    """Whether the edges of each hexahedron along each direction run against the others.

    Edges opposite each other in a face are parallel. All that are parallel shall run as they do in
    the first cell that has one of them.

    Parameters
    ----------
    corners
        Corners of each cell, (n_cells, 2, 2, 2).

    Returns
    -------
    ndarray
        Shape (n_cells, 3).
    """
    parallel = [np.moveaxis(corners, axis, -1).reshape(-1, 4, 2) for axis in (1, 2, 3)]
    edges = np.stack(parallel, axis=1)
    low, high = edges.min(axis=3), edges.max(axis=3)
    _, edge = np.unique(low * (corners.max() + 1) + high, return_inverse=True)
    # An edge is two nodes of a graph, one for each way along it: links join equal ways.
    way = 2 * edge.reshape(low.shape) + (edges[..., 0] == low)
    first, others = np.repeat(way[..., 0], 3), way[..., 1:].ravel()
    rows, columns = np.concatenate([first, first ^ 1]), np.concatenate([others, others ^ 1])
    size = 2 * (int(edge.max()) + 1)
    links = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(size, size))
    _, label = connected_components(links, directed=False)
    forth, back = label[way[..., 0]], label[way[..., 0] ^ 1]
    twisted = (forth == back).any(axis=1)
    require(
        not twisted.any(),
        "cells",
        f"{twisted.sum()} of {len(corners)} hexahedra",
        "parallel edges that can run the same way, so that faces are divided alike",
    )
    _, leader, sheet = np.unique(np.minimum(forth, back), return_index=True, return_inverse=True)
    return forth != forth.ravel()[leader][sheet.reshape(forth.shape)]
