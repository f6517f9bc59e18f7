"""Collapsed edges: rows of a control net whose points coincide, as on the axis of a polar patch.

The coinciding points of a row share one scalar dof, whose function is the sum of theirs, so that
the displacement is single-valued where the map is (Takacs & Juettler, Existence of stiffness
matrix integrals for singularly parameterized domains, 2011). Only elements next to such rows are
affected.
"""

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints

COLLAPSED = 1e-10
"""Distance, relative to the diagonal of the net, below which control points coincide."""

Lines = tuple[NDArray[np.bool_], ...]


def collapsed_lines(control_points: Floats) -> Lines:
    """Return True for the collapsed rows of a net along each axis, shaped as its other axes."""
    dim = control_points.shape[-1]
    diagonal = np.linalg.norm(np.ptp(control_points.reshape(-1, dim), axis=0))
    extents = [np.linalg.norm(np.ptp(control_points, axis=k), axis=-1) for k in range(dim)]
    return tuple(extent <= COLLAPSED * diagonal for extent in extents)


def face_is_collapsed(lines: Lines, axis: int, side: int) -> bool:
    """Return whether a face is collapsed to an edge or a point."""
    others = [k for k in range(len(lines)) if k != axis]
    # The array of rows along k has no axis k: later axes are shifted by one.
    return any(bool(np.take(lines[k], -side, axis=axis - (axis > k)).all()) for k in others)


def coinciding(lines: Lines, numbers: Ints) -> Ints:
    """Return pairs of control points that coincide, shape (n, 2)."""
    pairs = [np.empty((0, 2), dtype=np.int64)]
    for axis, collapsed in enumerate(lines):
        along = np.moveaxis(numbers, axis, -1)[collapsed]
        first = np.broadcast_to(along[:, :1], along.shape)
        pairs.append(np.stack([first.ravel(), along.ravel()], axis=1))
    return np.concatenate(pairs)
