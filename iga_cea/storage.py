"""PETSc matrices from the entries of the rows of each rank.

A scalar entry of row r at place t becomes, for each component a of the row, one tuple of columns:
all n components in a full block, or component a alone. Rows lie one after the other, those of the
components of a scalar row too. Those in columns of this rank come ahead of those in columns of
others.
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
"""Bytes that an entry is counted as: few enough are done at a time to stay in the cache."""


def block_matrix(pattern: Pattern, data: Floats, dim: int, comm: Any) -> Any:
    """AIJ matrix whose scalar entries are dim x dim blocks; the data become those of the matrix."""
    columns = pattern.columns.astype(PETSc.IntType)[:, None] * dim
    columns = columns + np.arange(dim, dtype=PETSc.IntType)
    indices = np.empty((dim * len(columns), dim), dtype=PETSc.IntType)
    for stretch in _stretches(pattern, dim):
        np.take(columns, stretch.source, axis=0, out=indices[stretch.part], mode="clip")
    return _matrix(pattern, data, indices.reshape(-1), dim, comm)


def component_matrix(pattern: Pattern, data: Floats, dim: int, comm: Any) -> Any:
    """AIJ matrix that has a scalar matrix in each component."""
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
    """Entries of a sum of Kronecker products, as :func:`block_matrix` takes them."""
    data = np.zeros((dim * len(pattern.columns), dim))
    for stretch in _stretches(pattern, dim):
        for scalar, factor in parts:
            values = scalar[stretch.source][:, None] * factor[stretch.component]
            data[stretch.part] += values
    return data.reshape(-1)


@dataclass(frozen=True)
class _Stretch:
    """Tuples that lie one after the other, those of the components of some scalar rows."""

    part: slice  # which these are of all
    source: Ints  # the scalar entry of each
    rows: Ints  # how many of them follow one another in a row of the matrix
    dim: int  # dimension of space

    @property
    def component(self) -> NDArray[Any]:
        """Component of the row of each."""
        every = np.arange(len(self.rows), dtype=PETSc.IntType) % self.dim
        return np.repeat(every, self.rows)


def _stretches(pattern: Pattern, dim: int) -> Iterator[_Stretch]:
    """All tuples in turn."""
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
