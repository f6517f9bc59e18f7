"""PETSc matrices from the entries of the rows of each rank.

A scalar entry becomes, for each component of its row, one tuple of columns: all n components in a
full block, or the same component alone. The rows of the components of a scalar row are consecutive.
The block in columns of this rank precedes that in columns of other ranks.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints, chunks
from cea.matrices import from_blocks
from cea.petsc import PETSc
from iga_cea.pattern import Pattern

_CACHED = 2**10
"""Assumed bytes per entry, chosen so that chunks fit the cache."""


def block_matrix(pattern: Pattern, data: Floats, dim: int, comm: Any) -> Any:
    """Return an AIJ matrix whose scalar entries are dim x dim blocks; it shares ``data``."""
    columns = pattern.columns.astype(PETSc.IntType)[:, None] * dim
    columns = columns + np.arange(dim, dtype=PETSc.IntType)
    indices = np.empty((dim * len(columns), dim), dtype=PETSc.IntType)
    for stretch in _stretches(pattern, dim):
        np.take(columns, stretch.source, axis=0, out=indices[stretch.part], mode="clip")
    return _matrix(pattern, data, indices.reshape(-1), dim, comm)


def component_matrix(pattern: Pattern, data: Floats, dim: int, comm: Any) -> Any:
    """Return an AIJ matrix with the same scalar matrix in each component."""
    columns = pattern.columns.astype(PETSc.IntType) * dim
    indices = np.empty(dim * len(columns), dtype=PETSc.IntType)
    values = np.empty(dim * len(columns))
    for stretch in _stretches(pattern, dim):
        part = indices[stretch.part]
        np.take(columns, stretch.source, out=part, mode="clip")
        part += stretch.component
        np.take(data, stretch.source, out=values[stretch.part], mode="clip")
    return _matrix(pattern, values, indices, dim, comm)


def combined(pattern: Pattern, parts: Sequence[tuple[Floats, Floats]], dim: int) -> Floats:
    """Return entries of a sum of Kronecker products for :func:`block_matrix`."""
    data = np.zeros((dim * len(pattern.columns), dim))
    for stretch in _stretches(pattern, dim):
        for scalar, factor in parts:
            values = scalar[stretch.source][:, None] * factor[stretch.component]
            data[stretch.part] += values
    return data.reshape(-1)


@dataclass(frozen=True)
class _Stretch:
    """Consecutive tuples, those of the components of a range of scalar rows."""

    part: slice  # range of the tuples
    source: Ints  # scalar entry of each tuple
    rows: Ints  # number of tuples in each row of the matrix
    dim: int  # dimension of space

    @property
    def component(self) -> NDArray[Any]:
        """Component of the row of each tuple."""
        every = np.arange(len(self.rows), dtype=PETSc.IntType) % self.dim
        return np.repeat(every, self.rows)


def _stretches(pattern: Pattern, dim: int) -> Iterator[_Stretch]:
    """Yield all tuples in chunks."""
    rows = len(pattern.counts)
    entries = len(pattern.columns) / max(1, rows)
    for part in chunks(rows, max(1.0, entries * dim * _CACHED)):
        counts, starts = pattern.counts[part], pattern.starts[part]
        end = int(pattern.starts[part.stop])
        ahead = ((dim - 1) * starts)[:, None] + counts[:, None] * np.arange(dim)
        lengths = np.repeat(counts, dim)
        every = slice(dim * int(starts[0]), dim * end)
        source = np.arange(every.start, every.stop)
        source -= np.repeat(ahead.ravel(), lengths)
        yield _Stretch(every, source, lengths, dim)


def _matrix(pattern: Pattern, data: Floats, indices: Any, dim: int, comm: Any) -> Any:
    lengths = np.repeat(pattern.counts * (len(indices) // (dim * len(pattern.columns) or 1)), dim)
    indptr = np.concatenate([[0], np.cumsum(lengths)])
    rows, first = (len(indptr) - 1) // 2, dim * pattern.first
    inner = int(indptr[rows])
    indices[:inner] -= first
    return from_blocks(
        (indptr[: rows + 1], indices[:inner], data[:inner]),
        (indptr[rows:] - inner, indices[inner:], data[inner:]),
        comm,
        block_size=dim,
    )
