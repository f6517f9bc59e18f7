"""Sparsity of matrices on joined patches, and positions of patch entries.

On a patch, functions i and j are coupled if they share a span along each parameter; the offset
j - i is then within the degree. A table per patch, with functions as rows and offsets as columns,
gives the position of each pair in its sparse row.

Entries in columns of this rank precede those in columns of other ranks, the two blocks of a PETSc
matrix. Each block has a sparse row for each scalar row.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Ints
from iga_cea.lines import Line
from iga_cea.multipatch import Multipatch
from iga_cea.patch import Patch
from iga_cea.sum_factorisation import Box


@dataclass(frozen=True)
class Pattern:
    """Scalar sparsity of the rows of one rank."""

    first: int  # first scalar dof of the rank
    last: int  # first scalar dof of the next rank
    # row pointers, first of the block in this rank's columns, then of that in other columns,
    # shape (2 * rows + 1,)
    starts: Ints
    columns: Ints  # global scalar dofs, increasing in each sparse row
    # for each patch the row of each function, -1 on other ranks, in the shape of the
    # net
    rows: tuple[Ints, ...]
    # for each patch the position in its sparse row of function i with offset j - i, -1 if there is
    # none, shape (functions of the rank, offsets)
    tables: tuple[Any, ...]
    # for each patch whether that is a column of another rank, of the same shape; None on a
    # single rank
    outer: tuple[Any, ...] | None

    @classmethod
    def of(cls, multipatch: Multipatch, rank: int) -> "Pattern":
        """Return the pattern of the matrices of a rank."""
        first, last = (int(n) for n in multipatch.dof_ranges[rank : rank + 2])
        total = multipatch.num_scalar_dofs
        rows, columns, keys, coupled = [], [], [], []
        for patch, dofs in zip(multipatch.patches, multipatch.dofs, strict=True):
            row = np.where((dofs >= first) & (dofs < last), dofs - first, -1)
            mine, flat = np.flatnonzero(row >= 0), dofs.ravel()
            pairs = _coupled(patch, mine)
            partner = (mine[:, None] + _steps(patch))[pairs]
            column = flat[partner]
            key = np.repeat(row.ravel()[mine] * total, np.count_nonzero(pairs, axis=1))
            key += column
            rows.append(row)
            columns.append(column)
            coupled.append(pairs)
            keys.append(key)
        every, column = np.concatenate(keys), np.concatenate(columns)
        place: Ints | None = None
        if not np.all(every[1:] > every[:-1]):
            every, place = np.unique(every, return_inverse=True)
            column = every % total
        starts = np.searchsorted(every, np.arange(last - first + 1) * total)
        beyond = None
        if last - first < total:
            beyond = (column < first) | (column >= last)
            starts, number = _apart(starts, beyond)
            ordered = np.empty_like(column)
            ordered[number] = column
            column, place = ordered, number if place is None else number[place]
        else:
            starts = np.append(starts, np.full(last - first, starts[-1]))
        tables, outer, done = [], [], 0
        for row, pairs in zip(rows, coupled, strict=True):
            part = slice(done, done + int(np.count_nonzero(pairs)))
            at = np.arange(part.start, part.stop) if place is None else place[part]
            of_row = np.repeat(row[row >= 0], np.count_nonzero(pairs, axis=1))
            if beyond is not None:
                far = at >= starts[last - first]
                of_row += (last - first) * far
                outer.append(_filled(pairs, far, fill=False))
            tables.append(_filled(pairs, (at - starts[of_row]).astype(np.int32), fill=-1))
            done = part.stop
        far_of = None if beyond is None else tuple(outer)
        return cls(first, last, starts, column, tuple(rows), tuple(tables), far_of)

    @property
    def num_inner(self) -> int:
        """Number of entries in columns of this rank."""
        return int(self.starts[self.last - self.first])

    def sparse_rows(self, patch: int, place: Any, row: Ints) -> Ints:
        """Return the sparse row of each pair of functions of a patch, (functions, offsets).

        The shape is (functions, 1) if it is the same for all offsets.
        """
        if self.outer is None or not self._has_outer[patch][place].any():
            return row[:, None]
        return row[:, None] + (self.last - self.first) * self.outer[patch][place]

    @cached_property
    def _has_outer(self) -> tuple[Any, ...]:
        """For each patch, whether a function is coupled with other ranks, (functions,)."""
        return tuple(table.any(axis=1) for table in self.outer or ())

    @cached_property
    def counts(self) -> Ints:
        """Number of entries of each sparse row."""
        return np.diff(self.starts)

    @cached_property
    def mirrored(self) -> tuple[Ints, Ints]:
        """Entries above the diagonal in this rank's columns, and their transposes."""
        n, inner = self.last - self.first, self.num_inner
        columns = self.columns[:inner] - self.first
        square = csr_array((np.arange(inner), columns, self.starts[: n + 1]), shape=(n, n))
        mirror = square.tocsc().data  # the pattern is symmetric
        above = np.flatnonzero(columns > self.row[:inner])
        return above, mirror[above]

    @property
    def row(self) -> Ints:
        """Sparse row of each entry."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    def boxes(self, patch: int) -> Iterator[Box]:
        """Yield boxes of functions that cover this rank's rows of a patch."""
        rows = self.rows[patch]
        for box in boxes_of(rows.reshape(*rows.shape, *(1,) * (3 - rows.ndim)) >= 0):
            yield box[0], box[1], box[2]


def _apart(starts: Ints, beyond: Any) -> tuple[Ints, Ints]:
    """Return row pointers and new positions when entries in other ranks' columns come last."""
    before = np.append(0, np.cumsum(beyond))
    inner = len(beyond) - int(before[-1])
    number = np.where(beyond, inner + before[:-1], np.arange(len(beyond)) - before[:-1])
    return np.append(starts - before[starts], inner + before[starts][1:]), number


def _filled(where: Any, values: Any, fill: Any) -> Any:
    """Return an array with values where ``where`` is True, and ``fill`` elsewhere."""
    filled = np.full(where.shape, fill, dtype=values.dtype)
    filled[where] = values
    return filled


def boxes_of(mask: np.ndarray) -> Iterator[tuple[slice, ...]]:
    """Divide a set of grid points into boxes: runs of equal cross sections along an axis."""
    if mask.ndim == 0:
        yield ()
        return
    for _, run in groupby(range(len(mask)), lambda k: mask[k].tobytes()):
        across = list(run)
        if mask[across[0]].any():
            for rest in boxes_of(mask[across[0]]):
                yield slice(across[0], across[-1] + 1), *rest


def _steps(patch: Patch) -> Ints:
    """Return the difference of the numbers of a function and its partner at each offset."""
    steps = np.zeros(1, dtype=np.int64)
    for p, n in zip(patch.degrees, patch.shape, strict=True):
        steps = (steps[:, None] * n + np.arange(-p, p + 1)).ravel()
    return steps


def _coupled(patch: Patch, functions: Ints) -> np.ndarray:
    """Return where functions are coupled with those at each offset, (functions, offsets)."""
    pairs = np.ones((len(functions), 1), dtype=bool)
    for axis, number in enumerate(np.unravel_index(functions, patch.shape)):
        along = Line.of(patch, axis).coupled[number]
        both = pairs.shape[1] * along.shape[1]
        pairs = (pairs[:, :, None] & along[:, None]).reshape(len(functions), both)
    return pairs
