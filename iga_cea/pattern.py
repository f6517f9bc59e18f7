"""Sparsity of matrices on joined patches, and where element entries go in it.

On a patch, functions i and j are coupled when they share a span along each parameter, and the
offset j - i is within the degree. So one table per patch, rows functions and columns offsets, says
where each pair lies in its sparse row; the entries of an element are read from it by offset alone.
"""

from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from cea.arrays import Floats, Ints
from cea.petsc import PETSc
from iga_cea.multipatch import Multipatch
from iga_cea.patch import Patch


@dataclass(frozen=True)
class Pattern:
    """Scalar sparsity of the rows and columns one rank touches.

    Parameters
    ----------
    dofs
        Global numbers of its local scalar dofs, rising.
    starts
        Where each sparse row starts, shape (local + 1,).
    columns
        Local columns, rising in each row.
    tables
        For each patch the place in its sparse row of function i with offset j - i, shape
        (functions, product of 2 degree + 1).
    rows
        For each patch the local scalar dof of each function, -1 where the rank touches it not.
    """

    dofs: Ints
    starts: Ints
    columns: Ints
    tables: tuple[Any, ...]
    rows: tuple[Ints, ...]

    @classmethod
    def of(cls, multipatch: Multipatch, rank: int) -> "Pattern":
        """Pattern of the matrices of a rank."""
        functions = [
            np.unique(patch_connectivity(patch, elements))
            for patch, elements in zip(
                multipatch.patches, multipatch.elements_of(rank), strict=True
            )
        ]
        flat = [dofs.ravel() for dofs in multipatch.dofs]
        local = np.unique(np.concatenate([d[f] for d, f in zip(flat, functions, strict=True)]))
        rows = []
        for d, f in zip(flat, functions, strict=True):
            row = np.full(len(d), -1)
            row[f] = np.searchsorted(local, d[f])
            rows.append(row)

        keys, places = [], []
        for patch, row in zip(multipatch.patches, rows, strict=True):
            function, offset, partner = _couplings(patch)
            here = (row[function] >= 0) & (row[partner] >= 0)
            function, offset, partner = function[here], offset[here], partner[here]
            keys.append(row[function] * len(local) + row[partner])
            places.append((function, offset))
        every = np.sort(np.concatenate(keys))
        every = every[np.diff(every, prepend=-1) > 0]
        starts = np.searchsorted(every, np.arange(len(local) + 1) * len(local))
        tables = []
        for patch, row, key, place in zip(multipatch.patches, rows, keys, places, strict=True):
            table = np.zeros((len(row), _offsets(patch)), dtype=np.int32)
            table[place] = np.searchsorted(every, key) - starts[row[place[0]]]
            tables.append(table)
        return cls(local, starts, every % max(len(local), 1), tuple(tables), tuple(rows))

    @property
    def counts(self) -> Ints:
        """Entries of each row."""
        return np.diff(self.starts)

    def block_rows(self, dim: int) -> tuple[Any, Any]:
        """CSR of the matrix whose scalar entries have become full dim x dim blocks."""
        counts = np.repeat(self.counts, dim)
        indptr = np.concatenate([[0], np.cumsum(counts * dim)]).astype(PETSc.IntType)
        # A row of blocks, repeated for each of its dim scalar rows.
        source = self._repeated(dim)
        columns = self.columns.astype(PETSc.IntType)[source] * dim
        indices = (columns[:, None] + np.arange(dim, dtype=PETSc.IntType)).ravel()
        return indptr, indices

    def expanded(self, values: Floats, dim: int) -> tuple[Any, Any, Floats]:
        """CSR of the matrix that has a scalar matrix in each component."""
        counts = np.repeat(self.counts, dim)
        indptr = np.concatenate([[0], np.cumsum(counts)]).astype(PETSc.IntType)
        source = self._repeated(dim)
        component = np.repeat(np.tile(np.arange(dim), len(self.counts)), counts)
        indices = (self.columns[source] * dim + component).astype(PETSc.IntType)
        return indptr, indices, values[source]

    def _repeated(self, dim: int) -> Ints:
        """Entries row by row, each row dim times in turn."""
        counts = np.repeat(self.counts, dim)
        ends = np.cumsum(counts)
        shift = np.repeat(self.starts[:-1], dim) - (ends - counts)
        return np.arange(ends[-1] if len(ends) else 0) + np.repeat(shift, counts)


def patch_connectivity(patch: Patch, elements: Ints) -> Ints:
    """Functions of each element in C order, shape (elements, functions per element)."""
    spans = np.unravel_index(elements, patch.spans)
    number = np.zeros((len(elements), 1), dtype=np.int64)
    for first, span, degree, n in zip(
        patch.first_functions, spans, patch.degrees, patch.shape, strict=True
    ):
        along = first[span][:, None] + np.arange(degree + 1)
        numbers = number[:, :, None] * n + along[:, None]
        number = numbers.reshape(len(elements), numbers.shape[1] * numbers.shape[2])
    return number


def pair_offsets(patch: Patch) -> Ints:
    """Column of the table for each pair of functions of an element, shape (functions, functions).

    The offset between two functions of an element does not depend on the element.
    """
    offset = np.zeros((1, 1), dtype=np.int64)
    for p in patch.degrees:
        along = np.arange(p + 1)[None, :] - np.arange(p + 1)[:, None] + p
        offset = np.kron(offset, np.ones_like(along)) * (2 * p + 1) + np.tile(along, offset.shape)
    return offset


def _offsets(patch: Patch) -> int:
    return int(np.prod([2 * p + 1 for p in patch.degrees]))


def _couplings(patch: Patch) -> tuple[Ints, Ints, Ints]:
    """Coupled pairs of a patch: function i, column of the table, function j."""
    along = []
    for first, p, n in zip(patch.first_functions, patch.degrees, patch.shape, strict=True):
        coupled = np.zeros((n, n), dtype=bool)
        for a in range(p + 1):
            for b in range(p + 1):
                coupled[first + a, first + b] = True
        i, j = np.nonzero(coupled)
        along.append((i, j - i + p, j, n, 2 * p + 1))

    def combine(left: tuple, right: tuple) -> tuple:
        i, offset, j = (
            (a[:, None] * size + b).ravel()
            for a, b, size in zip(left[:3], right[:3], (right[3], right[4], right[3]), strict=True)
        )
        return i, offset, j, left[3] * right[3], left[4] * right[4]

    function, offset, partner, _, _ = reduce(combine, along)
    return function, offset, partner
