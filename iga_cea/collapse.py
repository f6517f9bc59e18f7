"""Collapsed edges: lines of a net whose control points coincide, as at the axis of a polar patch.

The coinciding points of a line are one scalar dof, whose function is the sum of theirs: then the
displacement has one value where the patch has one point (Takacs & Juettler, Existence of stiffness
matrix integrals for singularly parameterized domains, 2011). Only elements beside such lines are
concerned.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints

COLLAPSED = 1e-10
"""Distance at which control points of a line coincide, relative to the diagonal of the net."""

Lines = tuple[NDArray[np.bool_], ...]


def collapsed_lines(control_points: Floats) -> Lines:
    """True for the collapsed lines of a net along each axis, in the shape of its other axes.

    Parameters
    ----------
    control_points
        Net (m), shape (n1, ..., dim).
    """
    dim = control_points.shape[-1]
    diagonal = np.linalg.norm(np.ptp(control_points.reshape(-1, dim), axis=0))
    extents = [np.linalg.norm(np.ptp(control_points, axis=k), axis=-1) for k in range(dim)]
    return tuple(extent <= COLLAPSED * diagonal for extent in extents)


def face_is_collapsed(lines: Lines, axis: int, side: int) -> bool:
    """True when a face is no more than an edge or a point.

    Parameters
    ----------
    lines
        Collapsed lines of the net.
    axis, side
        The face.
    """
    others = [k for k in range(len(lines)) if k != axis]
    # The lines along k lack axis k: what lies behind it has moved up by one.
    return any(bool(np.take(lines[k], -side, axis=axis - (axis > k)).all()) for k in others)


def coinciding(lines: Lines, numbers: Ints) -> Ints:
    """Pairs of control points that coincide, shape (n, 2).

    Parameters
    ----------
    lines
        Collapsed lines of the net.
    numbers
        Numbers of its control points, in the shape of the net.
    """
    pairs = [np.empty((0, 2), dtype=np.int64)]
    for axis, collapsed in enumerate(lines):
        along = np.moveaxis(numbers, axis, -1)[collapsed]
        first = np.broadcast_to(along[:, :1], along.shape)
        pairs.append(np.stack([first.ravel(), along.ravel()], axis=1))
    return np.concatenate(pairs)


def separated(
    lines: Lines, first_functions: Sequence[Ints], degrees: Sequence[int], elements: Ints
) -> Iterator[tuple[Ints, bool]]:
    """Elements away from collapsed lines, then those beside them in groups.

    In each group every element has its own lines, so that one local function belongs to a
    different dof in each. Groups are as many as there are spans along a collapsed line.

    Parameters
    ----------
    lines
        Collapsed lines of the refined net.
    first_functions
        Number of the first function on each span, along each parameter.
    degrees
        Degree along each parameter.
    elements
        Elements in C order of their spans.

    Yields
    ------
    tuple
        Elements, and whether they lie beside a collapsed line.
    """
    counts = tuple(len(first) for first in first_functions)
    spans = np.unravel_index(elements, counts)
    key = np.full((len(elements), len(counts)), -1)
    for axis, line in enumerate(lines):
        if not line.any():
            continue
        beside = line
        for k, other in enumerate(o for o in range(len(counts)) if o != axis):
            functions = first_functions[other][:, None] + np.arange(degrees[other] + 1)
            beside = np.take(beside, functions, axis=k).any(axis=k + 1)
        everywhere = np.broadcast_to(np.expand_dims(beside, axis), counts)
        touched = everywhere.ravel()[elements]
        key[touched, axis] = spans[axis][touched]
    regular = (key < 0).all(axis=1)
    yield elements[regular], False
    if regular.all():
        return
    special = elements[~regular]
    _, group = np.unique(key[~regular], axis=0, return_inverse=True)
    for number in range(int(group.max()) + 1):
        yield special[group.ravel() == number], True


def merging(dofs: Ints) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Elements sorted by which of their functions are one dof.

    Parameters
    ----------
    dofs
        Scalar dofs of the functions of elements beside collapsed lines, (elements, functions).

    Yields
    ------
    tuple
        Rows of ``dofs`` alike; the functions that stand for their dofs (m,); the 0-1 matrix
        (functions, m) that sums functions of one dof.
    """
    first = np.stack([(dofs == dofs[:, a, None]).argmax(axis=1) for a in range(dofs.shape[1])], 1)
    patterns, group = np.unique(first, axis=0, return_inverse=True)
    for number, pattern in enumerate(patterns):
        kept, place = np.unique(pattern, return_inverse=True)
        yield np.flatnonzero(group.ravel() == number), kept, np.eye(len(kept))[place]
