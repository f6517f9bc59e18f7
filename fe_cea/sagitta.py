"""Distance of facets from an unknown smooth surface, estimated from angles between them.

Two neighbours whose normals differ by the angle t along their common edge, and that extend by L and
L' normal to it, lie on a surface of curvature 2 t / (L + L') there. The sagitta of a chord of
length L is

    e = t L^2 / (4 (L + L')),

which is L t / 8 for equal facets. For curved facets, whose normals differ by less, this exceeds the
distance: by a factor of four for quadratic facets on a circle. Sagittas along both directions of a
surface add up. Normals that differ by more than 50 degrees belong to an edge of the body.
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
"""Edges (ends in 2D) of the reference facet that are crossed in the same direction."""


def sagittas(kind: Any, nodes: Floats, dofs: Ints, normals: Floats) -> Floats:
    """Return the estimated distance (m) of facets from the smooth surface, (n,).

    ``kind`` is the facet type, ``nodes`` (m), (n, n_nodes, dim), ``normals`` are outward unit
    normals at the corners, (n, n_corners, dim).
    """
    corners = np.array(basix.topology(kind)[nodes.shape[2] - 2])  # corners of each edge
    reach = _reach(nodes, corners)
    found = np.zeros(reach.shape)
    (facet, edge), (other, its_edge) = _neighbours(dofs, corners)
    angle = np.zeros(len(facet))
    for k in range(corners.shape[1]):
        for own, others in ((k, k), (k, -1 - k)):  # neighbours may list them in reverse
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
    """Return the extent of each facet normal to each of its edges (m), (n_facets, n_edges)."""
    start, stop = nodes[:, corners[:, 0]], nodes[:, corners[:, -1]]
    arm = nodes[:, None] - start[:, :, None]
    along = stop - start
    along /= np.maximum(np.linalg.norm(along, axis=2, keepdims=True), np.finfo(float).tiny)
    across = arm - np.einsum("fend,fed->fen", arm, along)[..., None] * along[:, :, None]
    return np.linalg.norm(across, axis=3).max(axis=2)


def _neighbours(dofs: Ints, corners: Ints) -> tuple[tuple[Ints, Ints], tuple[Ints, Ints]]:
    """Return facets with a common edge and their edges, each pair in both orders, (n,) each."""
    ends = np.sort(dofs[:, corners], axis=2)
    _, group = np.unique(ends.reshape(-1, corners.shape[1]), axis=0, return_inverse=True)
    order = np.argsort(group, kind="stable")
    pairs = np.flatnonzero(np.diff(group[order]) == 0)
    first, second = order[pairs], order[pairs + 1]
    count = len(corners)
    one = np.divmod(np.concatenate([first, second]), count)
    return one, np.divmod(np.concatenate([second, first]), count)
