"""Distinction of mesh facets that join smoothly, as on a curved surface, and at corners.

The angle between neighbouring facets decreases with refinement on a smooth surface, not at a
corner. For facets inscribed in a circle with central angles s and t, the normals of neighbours
differ by (s + t) / 2, and from those of their other neighbours by at least s / 2 and t / 2: facets
of any lengths turn by at most twice the larger of the angles at their far ends. Facets that turn
by more meet at a corner.
"""

import numpy as np

from cea.arrays import Floats, Ints
from cea.surface_points import TANGENT, pairs_of_equal

CREASE = np.cos(np.deg2rad(50.0))
"""Cosine below which facets meet at a corner in any case.

A box with one facet per side turns as uniformly as a circle; eight or more facets around are a
circle.
"""


def smooth_pairs(dofs: Ints, normals: Floats, on_side: int) -> Ints:
    """Return pairs of facets that join smoothly."""
    entries = pairs_of_equal(dofs.ravel())
    one, other = normals.reshape(-1, normals.shape[2])[entries.T]
    turn = angles(one, other)
    crease = np.arccos(CREASE)
    at_node = np.zeros(dofs.size)
    np.maximum.at(at_node, entries.ravel(), np.repeat(np.where(turn > crease, 0.0, turn), 2))

    low, high = np.sort(entries // dofs.shape[1], axis=1).T
    number, pair, common = np.unique(
        low * len(dofs) + high, return_inverse=True, return_counts=True
    )
    pairs = np.column_stack(np.divmod(number, len(dofs)))
    between = np.zeros(len(pairs))
    np.maximum.at(between, pair, turn)
    smooth = between <= np.arccos(TANGENT)
    curved = np.flatnonzero(~smooth & (common >= on_side) & (between <= crease))
    elsewhere = [
        np.maximum(
            _at_far_nodes(dofs, at_node.reshape(dofs.shape), facet, neighbour),
            _inside(normals[facet]),
        )
        for facet, neighbour in (pairs[curved].T, pairs[curved].T[::-1])
    ]
    smooth[curved] = between[curved] <= 2 * np.maximum(*elsewhere)
    return pairs[smooth]


def _at_far_nodes(dofs: Ints, at_node: Floats, facet: Ints, neighbour: Ints) -> Floats:
    """Return the angle (rad) of facets to others at nodes that a neighbour does not share."""
    shared = (dofs[facet][:, :, None] == dofs[neighbour][:, None, :]).any(axis=2)
    return np.where(shared, 0.0, at_node[facet]).max(axis=1, initial=0.0)


def _inside(normals: Floats) -> Floats:
    """Return the largest angle (rad) between normals at the nodes of a facet, (facets,)."""
    cosine = np.einsum("fni,fmi->fnm", normals, normals).min(axis=(1, 2), initial=1.0)
    return np.arccos(np.clip(cosine, -1.0, 1.0))


def angles(one: Floats, other: Floats) -> Floats:
    """Return angles between unit vectors (rad), accurate for small angles, (n,)."""
    return 2 * np.arcsin(np.minimum(np.linalg.norm(one - other, axis=1) / 2, 1.0))
