"""How far facets lie from a smooth surface that nobody told: estimated from angles between them.

Two neighbours whose normals differ by t along their common edge, and that reach L and L' across it,
lie on a surface of curvature 2 t / (L + L') there. The arc of that curvature leaves a chord of
length L by

    e = t L^2 / (4 (L + L')),

the sagitta, which is L t / 8 among equals. Of curved facets, whose normals differ by less, this is
more than their distance: four times it on a circle where they are quadratic. Curvatures along both
directions of a surface add up. Where normals differ by more than 50 degrees bodies have an edge.
"""

from typing import Any

import basix
import numpy as np

from cea.arrays import Floats, Ints
from fe_cea.corners import CREASE, angles

_ACROSS = {
    basix.CellType.interval: ((0, 1),),
    basix.CellType.triangle: ((0,), (1,), (2,)),
    basix.CellType.quadrilateral: ((0, 3), (1, 2)),
}
"""Edges (ends in 2D) of the reference facet that the same direction crosses."""


def sagittas(kind: Any, nodes: Floats, dofs: Ints, normals: Floats) -> Floats:
    """Estimated distance (m) of facets of a kind from the smooth surface they stand for, (n,).

    Of their nodes (m), (n, n_nodes, dim), dofs, and outward unit normals at their corners,
    (n, n_corners, dim).
    """
    corners = np.array(basix.topology(kind)[nodes.shape[2] - 2])  # of each edge
    reach = _reach(nodes, corners)
    found = np.zeros(reach.shape)
    (facet, edge), (other, its_edge) = _neighbours(dofs, corners)
    angle = np.zeros(len(facet))
    for k in range(corners.shape[1]):
        for own, others in ((k, k), (k, -1 - k)):  # neighbours may list them the other way round
            mine, its = corners[edge, own], corners[its_edge, others]
            same = dofs[facet, mine] == dofs[other, its]
            turned = angles(normals[facet, mine], normals[other, its])
            angle = np.maximum(angle, np.where(same, turned, 0.0))
    length, beyond = reach[facet, edge], reach[other, its_edge]
    smooth = angle < np.arccos(CREASE)
    found[facet, edge] = np.where(smooth, angle * length**2 / (4 * (length + beyond)), 0.0)
    along = [found[:, list(edges)].max(axis=1) for edges in _ACROSS[kind]]
    return np.sum(along, axis=0)


def _reach(nodes: Floats, corners: Ints) -> Floats:
    """How far each facet reaches from each of its edges (m), (n_facets, n_edges)."""
    start, stop = nodes[:, corners[:, 0]], nodes[:, corners[:, -1]]
    arm = nodes[:, None] - start[:, :, None]
    along = stop - start
    along /= np.maximum(np.linalg.norm(along, axis=2, keepdims=True), np.finfo(float).tiny)
    across = arm - np.einsum("fend,fed->fen", arm, along)[..., None] * along[:, :, None]
    return np.linalg.norm(across, axis=3).max(axis=2)


def _neighbours(dofs: Ints, corners: Ints) -> tuple[tuple[Ints, Ints], tuple[Ints, Ints]]:
    """Facets with a common edge, each pair both ways: facets and their edges, (n,) each."""
    ends = np.sort(dofs[:, corners], axis=2)
    _, group = np.unique(ends.reshape(-1, corners.shape[1]), axis=0, return_inverse=True)
    order = np.argsort(group, kind="stable")
    pairs = np.flatnonzero(np.diff(group[order]) == 0)
    first, second = order[pairs], order[pairs + 1]
    count = len(corners)
    one = np.divmod(np.concatenate([first, second]), count)
    return one, np.divmod(np.concatenate([second, first]), count)
