"""Sparsity of matrices on joined patches, and where entries of patches go in it.

On a patch, functions i and j are coupled when they share a span along each parameter, and the
offset j - i is within the degree. So one table per patch, rows functions and columns offsets, says
where each pair lies in its sparse row.
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
    """Scalar sparsity of the rows of one rank.

    Parameters
    ----------
    first, last
        Its scalar dofs.
    starts
        Where each sparse row starts, shape (rows + 1,).
    columns
        Global scalar dofs, rising in each row.
    rows
        For each patch the row of each function, -1 where it is another rank's, in the shape of the
        net.
    tables
        For each patch the place in its sparse row of function i with offset j - i, -1 where there
        is none, shape (functions of the rank, offsets).
    """

    first: int
    last: int
    starts: Ints
    columns: Ints
    rows: tuple[Ints, ...]
    tables: tuple[Any, ...]

    @classmethod
    def of(cls, multipatch: Multipatch, rank: int) -> "Pattern":
        """Pattern of the matrices of a rank."""
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
        tables, done = [], 0
        for row, pairs in zip(rows, coupled, strict=True):
            table = np.full(pairs.shape, -1, dtype=np.int32)
            in_row = np.count_nonzero(pairs, axis=1)
            part = slice(done, done + int(in_row.sum()))
            at = np.arange(part.start, part.stop) if place is None else place[part]
            table[pairs] = at - np.repeat(starts[row[row >= 0]], in_row)
            tables.append(table)
            done = part.stop
        return cls(first, last, starts, column, tuple(rows), tuple(tables))

    @cached_property
    def counts(self) -> Ints:
        """Entries of each row."""
        return np.diff(self.starts)

    @cached_property
    def mirrored(self) -> tuple[Ints, Ints]:
        """Entries above the diagonal whose column is this rank's, and their mirror images."""
        mine = (self.columns >= self.first) & (self.columns < self.last)
        entries = np.flatnonzero(mine)
        before = np.concatenate([[0], np.cumsum(mine)])
        columns = self.columns[entries] - self.first
        n = self.last - self.first
        square = csr_array((entries, columns, before[self.starts]), shape=(n, n))
        mirror = square.tocsc().data  # the pattern is symmetric
        above = columns > self.row[entries]
        return entries[above], mirror[above]

    @property
    def row(self) -> Ints:
        """Row of each entry."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    def boxes(self, patch: int) -> Iterator[Box]:
        """Boxes of functions that make up the rows of a patch which are this rank's."""
        rows = self.rows[patch]
        for box in boxes_of(rows.reshape(*rows.shape, *(1,) * (3 - rows.ndim)) >= 0):
            yield box[0], box[1], box[2]


def boxes_of(mask: np.ndarray) -> Iterator[tuple[slice, ...]]:
    """Cut a set of points of a grid into boxes: runs along an axis of equal cuts across it.

    Parameters
    ----------
    mask
        True for the points of the set.
    """
    if mask.ndim == 0:
        yield ()
        return
    for _, run in groupby(range(len(mask)), lambda k: mask[k].tobytes()):
        across = list(run)
        if mask[across[0]].any():
            for rest in boxes_of(mask[across[0]]):
                yield slice(across[0], across[-1] + 1), *rest


def _steps(patch: Patch) -> Ints:
    """Difference of the numbers of a function and its partner at each offset."""
    steps = np.zeros(1, dtype=np.int64)
    for p, n in zip(patch.degrees, patch.shape, strict=True):
        steps = (steps[:, None] * n + np.arange(-p, p + 1)).ravel()
    return steps


def _coupled(patch: Patch, functions: Ints) -> np.ndarray:
    """True where functions are coupled with those at each offset, (functions, offsets)."""
    pairs = np.ones((len(functions), 1), dtype=bool)
    for axis, number in enumerate(np.unravel_index(functions, patch.shape)):
        along = Line.of(patch, axis).coupled[number]
        both = pairs.shape[1] * along.shape[1]
        pairs = (pairs[:, :, None] & along[:, None]).reshape(len(functions), both)
    return pairs
