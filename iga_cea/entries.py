"""Matrix entries of a form on joined patches, exactly symmetric or skew on any number of ranks.

Each rank computes all contributions to its rows, from every patch, so that ranks need not sum
anything. With n components, the entries of a scalar row are stored as n rows, each with the n
components of every column in turn.
"""

from typing import Any

import numpy as np

from cea.arrays import Floats, Ints, chunks
from cea.ranks import agreed
from iga_cea.metric import Map, factors_of, lines_of
from iga_cea.multipatch import Multipatch
from iga_cea.pattern import Pattern
from iga_cea.sum_factorisation import Form, slabs


def entries(
    multipatch: Multipatch,
    pattern: Pattern,
    form: Form,
    comm: Any,
    *,
    sign: int = 1,
) -> Floats:
    """Return the entries of the rows of this rank, flat."""
    n = form.components
    # An additional entry collects those of partners that do not exist.
    data = np.zeros((n * len(pattern.columns) + 1, n))
    with agreed(comm):
        for number in range(len(multipatch.patches)):
            _add_patch(data, multipatch, pattern, form, number)
    flat = data[:-1].reshape(-1)
    _mirror(flat, pattern, n, sign)
    if comm.size > 1:
        _exchange(flat, multipatch, pattern, n, sign, comm)
    return flat


def _add_patch(
    data: Floats, multipatch: Multipatch, pattern: Pattern, form: Form, number: int
) -> None:
    patch, n = multipatch.patches[number], form.components
    factors = factors_of(patch.weights)
    lines = lines_of(patch, factors)

    field = None if form.field is None else form.field[multipatch.dofs[number]]

    def patch_map(across: list[tuple[Floats, Floats]]) -> Map:
        return Map(patch, factors is not None, across, field, f"patches[{number}]")

    rows = pattern.rows[number]
    rows = rows.reshape(*rows.shape, *(1,) * (3 - rows.ndim))
    place_of = (np.cumsum(rows >= 0) - 1).reshape(rows.shape)
    alone = len(multipatch.patches) == 1
    own = multipatch.dofs[number]
    several = len(np.unique(own)) < own.size  # several functions per dof, as at collapsed edges
    for box in pattern.boxes(number):
        for i, part, slab in slabs(patch_map, lines, form, box):
            here = (i, part, box[2])
            chosen = place_of[here].ravel()
            if factors is None:
                slab = slab * _weights(patch.weights.reshape(rows.shape), lines, here)
            row = pattern.sparse_rows(number, chosen, rows[here].ravel())[:, None]
            place = pattern.tables[number][chosen][:, None, :]
            component = np.arange(n)[:, None]
            at = place + (n * pattern.starts[row] + pattern.counts[row] * component)
            at[np.broadcast_to(place < 0, at.shape)] = len(data) - 1
            if several:
                np.add.at(
                    data.reshape(-1), (at[..., None] * n + np.arange(n)).ravel(), slab.ravel()
                )
            elif alone:
                data[at] = slab
            else:
                data[at] += slab


def _weights(weights: Floats, lines: Any, here: Any) -> Floats:
    """Return products of the weights of the functions of a slab and their partners."""
    padded = np.pad(weights, [(line.degree, line.degree) for line in lines])
    windows = np.lib.stride_tricks.sliding_window_view(padded, [line.offsets for line in lines])
    own = windows[here].reshape(-1, int(np.prod([line.offsets for line in lines])))
    return (weights[here].reshape(-1, 1) * own)[:, None, :, None]


def _tuples(pattern: Pattern, at: Ints, row: Ints, n: int) -> Ints:
    """Return the tuples of scalar entries in the first of their n rows.

    In each following row they are shifted by the number of entries of the row.
    """
    return at + (n - 1) * pattern.starts[row]


def _mirror(data: Floats, pattern: Pattern, n: int, sign: int) -> None:
    """Copy the entries above the diagonal to those below."""
    tuples, rows = data.reshape(-1, n), pattern.row
    above, below = pattern.mirrored
    for part in chunks(len(above), 16 * n * (n + 4)):
        up, down = above[part], below[part]
        source, step = _tuples(pattern, up, rows[up], n), pattern.counts[rows[up]]
        target, jump = _tuples(pattern, down, rows[down], n), pattern.counts[rows[down]]
        blocks = np.empty((n, len(up), n))
        for a in range(n):
            blocks[:, :, a] = tuples[source + a * step].T
        if sign < 0:
            np.negative(blocks, out=blocks)
        for b in range(n):
            tuples[target + b * jump] = blocks[b]
    inner = pattern.num_inner
    diagonal = np.flatnonzero(pattern.columns[:inner] == pattern.first + rows[:inner])
    at, step = _tuples(pattern, diagonal, rows[diagonal], n), pattern.counts[: len(diagonal)]
    for a in range(n):
        if sign < 0:
            tuples[at + a * step, a] = 0.0
        for b in range(a + 1, n):
            tuples[at + b * step, a] = sign * tuples[at + a * step, b]


def _exchange(
    data: Floats, multipatch: Multipatch, pattern: Pattern, n: int, sign: int, comm: Any
) -> None:
    """Receive the entries in columns of lower ranks from these ranks."""
    tuples, rows, ranges = data.reshape(-1, n), pattern.row, multipatch.dof_ranges
    outer = pattern.columns[pattern.num_inner :]

    def places(low: int, high: int, *, by_columns: bool) -> Ints:
        """Return tuples of entries with columns in a range, (entries, rows of each)."""
        at = pattern.num_inner + np.flatnonzero((outer >= low) & (outer < high))
        if by_columns:
            at = at[np.argsort(pattern.columns[at], kind="stable")]
        step = pattern.counts[rows[at]]
        return _tuples(pattern, at, rows[at], n)[:, None] + step[:, None] * np.arange(n)

    # In the order of the receiving rank: by its rows, which are columns here.
    send = [
        sign * tuples[places(*ranges[rank : rank + 2], by_columns=True)].swapaxes(1, 2)
        if rank > comm.rank
        else None
        for rank in range(comm.size)
    ]
    for rank, values in enumerate(comm.alltoall(send)):
        if values is not None:
            tuples[places(*ranges[rank : rank + 2], by_columns=False)] = values
