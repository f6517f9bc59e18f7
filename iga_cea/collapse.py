"""Collapsed edges: lines of a net whose control points coincide, as at the axis of a polar patch.

The coinciding points of a line are one scalar dof, whose function is the sum of theirs: then the
displacement has one value where the patch has one point (Takacs & Juettler, Existence of stiffness
matrix integrals for singularly parameterized domains, 2011). Only elements beside such lines are
concerned.
"""

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints

COLLAPSED = 1e-10
"""Distance at which control points of a line coincide, relative to the diagonal of the net."""

Lines = tuple[NDArray[np.bool_], ...]


def collapsed_lines(control_points: Floats) -> Lines:
    """True for the collapsed lines of a net along each axis, in the shape of its other axes."""
    dim = control_points.shape[-1]
    diagonal = np.linalg.norm(np.ptp(control_points.reshape(-1, dim), axis=0))
    extents = [np.linalg.norm(np.ptp(control_points, axis=k), axis=-1) for k in range(dim)]
    return tuple(extent <= COLLAPSED * diagonal for extent in extents)


def face_is_collapsed(lines: Lines, axis: int, side: int) -> bool:
    """True when a face is no more than an edge or a point."""
    others = [k for k in range(len(lines)) if k != axis]
    # The lines along k lack axis k: what lies behind it has moved up by one.
    return any(bool(np.take(lines[k], -side, axis=axis - (axis > k)).all()) for k in others)


def coinciding(lines: Lines, numbers: Ints) -> Ints:
    """Pairs of control points that coincide, shape (n, 2)."""
    pairs = [np.empty((0, 2), dtype=np.int64)]
    for axis, collapsed in enumerate(lines):
        along = np.moveaxis(numbers, axis, -1)[collapsed]
        first = np.broadcast_to(along[:, :1], along.shape)
        pairs.append(np.stack([first.ravel(), along.ravel()], axis=1))
    return np.concatenate(pairs)
