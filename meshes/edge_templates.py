"""What a square is divided into towards corners of it, in geometric layers.

Towards one corner: a smaller square there, with sides of a part q, and two quadrilaterals that pass
over from its inner sides to those of the square that do not meet in the corner. These stay whole.
Towards two corners of one side: a smaller square in both, the stretch between them, and four that
pass over to the other sides. A further layer divides the smaller squares again.
"""

import numpy as np
from numpy.typing import NDArray

from cea.errors import InputError
from cea.mesh import Floats
from meshes.singular_edges import TOO_FEW

RATIO = 0.2
"""Size of a cell of a layer relative to the next one: near what suits corners best."""
_TURN = np.array([0.55, 0.3])
"""Where the cells between two edges turn, in parts of the cell: away from the side that both are
on, and along it."""


def quads_towards(marked: NDArray[np.bool_], layers: int) -> Floats:
    """What a square is divided into towards marked corners, (n, 2, 2, 2).

    Corners [i, j] of each quadrilateral by their two coordinates, from 0 to 1; of right hand.
    """
    whole = np.stack(np.meshgrid([0.0, 1.0], [0.0, 1.0], indexing="ij"), axis=-1)[None]
    if not layers:
        return whole
    corners = np.argwhere(marked)
    alone = len(corners) == 1
    shared = [] if alone else np.flatnonzero((corners == corners[0]).all(axis=0)).tolist()
    if not alone and (len(corners) > 2 or not shared):
        raise InputError("elements", f"{len(corners)} edges at a cell", TOO_FEW)
    corner = np.array([[True, False], [False, False]])
    small = RATIO * quads_towards(corner, layers - 1)
    quads = _around_one(small) if alone else _around_two(small)
    if not alone and shared[0] == 1:
        quads = quads.swapaxes(1, 2)[..., ::-1]
    for axis in range(2):
        if corners[0, axis] == 1:
            quads = np.flip(quads, axis=1 + axis).copy()
            quads[..., axis] = 1 - quads[..., axis]
    return quads


def _around_one(small: Floats) -> Floats:
    """Towards the corner (0, 0), which is divided already."""
    q = RATIO
    along = [[[q, 0], [q, q]], [[1, 0], [1, 1]]]
    up = [[[0, q], [0, 1]], [[q, q], [1, 1]]]
    return np.concatenate([small, np.array([along, up], dtype=float)])


def _around_two(small: Floats) -> Floats:
    """Towards the corners (0, 0) and (0, 1), of which the first is divided already."""
    q, (a, b) = RATIO, _TURN
    low = np.concatenate([small, np.array([[[[q, 0], [q, q]], [[1, 0], [a, b]]]])])
    high = np.flip(low, axis=2).copy()
    high[..., 1] = 1 - high[..., 1]
    between = [
        [[[0, q], [0, 1 - q]], [[q, q], [q, 1 - q]]],
        [[[q, q], [q, 1 - q]], [[a, b], [a, 1 - b]]],
        [[[a, b], [a, 1 - b]], [[1, 0], [1, 1]]],
    ]
    return np.concatenate([low, high, np.array(between)])
