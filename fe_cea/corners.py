"""Which facets of a mesh join smoothly, as those of a curved surface do, and which at a corner.

Facets of a smooth surface turn less from one to the next the finer they are, those at a corner do
not. Inscribed in a circle, neighbours that are seen from the centre under
the angles s and t differ by (s + t) / 2 in their normals, and from their next neighbours by s / 2
and t / 2 at least: facets of any lengths turn by no more than twice what they turn at the larger of
their far ends. Those that turn by more meet at a corner.
"""

import numpy as np

from cea.arrays import Floats, Ints
from cea.surface_points import TANGENT, pairs_of_equal

CREASE = np.cos(np.deg2rad(50.0))
"""Facets whose normals differ by more meet at a corner, whatever they do elsewhere.

Those of a box with one facet a side turn as evenly as those of a circle. Eight facets or more that
go round are a circle.
"""


def smooth_pairs(dofs: Ints, normals: Floats, on_side: int) -> Ints:
    """Pairs of facets that join smoothly."""
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
    """Angle (rad) by which facets turn to others at nodes that a neighbour does not share."""
    shared = (dofs[facet][:, :, None] == dofs[neighbour][:, None, :]).any(axis=2)
    return np.where(shared, 0.0, at_node[facet]).max(axis=1, initial=0.0)


def _inside(normals: Floats) -> Floats:
    """Largest angle (rad) between normals at the nodes of a facet, (facets,)."""
    cosine = np.einsum("fni,fmi->fnm", normals, normals).min(axis=(1, 2), initial=1.0)
    return np.arccos(np.clip(cosine, -1.0, 1.0))


def angles(one: Floats, other: Floats) -> Floats:
    """Angles between unit vectors (rad), exact where they are small, (n,)."""
    return 2 * np.arcsin(np.minimum(np.linalg.norm(one - other, axis=1) / 2, 1.0))
