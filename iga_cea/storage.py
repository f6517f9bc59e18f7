"""PETSc matrices from the entries of the rows of each rank.

A scalar entry becomes, for each component of its row, one tuple of columns: all n components in a
full block, or the same component alone. The rows of the components of a scalar row are consecutive.
The block in columns of this rank precedes that in columns of other ranks.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints
from cea.matrices import from_blocks
from cea.petsc import PETSc
from iga_cea.pattern import Pattern


def block_matrix(pattern: Pattern, data: Floats, dim: int, comm: Any) -> Any:
    """Return an AIJ matrix whose scalar entries are dim x dim blocks; it shares ``data``."""
    rows = _repeated(pattern, dim)
    indices = rows.indices[:, None] * dim + np.arange(dim, dtype=rows.indices.dtype)
    return _matrix(pattern, data, indices.ravel(), dim * rows.indptr, dim, comm)


def component_matrix(pattern: Pattern, data: Floats, dim: int, comm: Any) -> Any:
    """Return an AIJ matrix with the same scalar matrix in each component."""
    rows = _repeated(pattern, dim)
    indices = rows.indices * dim + _components(rows, dim)
    return _matrix(pattern, data[rows.data], indices, rows.indptr, dim, comm)


def combined(pattern: Pattern, parts: Sequence[tuple[Floats, Floats]], dim: int) -> Floats:
    """Return entries of a sum of Kronecker products for :func:`block_matrix`."""
    rows = _repeated(pattern, dim)
    component, data = _components(rows, dim), np.zeros((rows.nnz, dim))
    for scalar, factor in parts:
        data += scalar[rows.data][:, None] * factor[component]
    return data.reshape(-1)


def _repeated(pattern: Pattern, dim: int) -> csr_array:
    """Return the scalar rows, each ``dim`` times; values are the numbers of the scalar entries."""
    count, columns = len(pattern.counts), pattern.columns
    shape = (count, int(columns.max(initial=0)) + 1)
    number = np.arange(len(columns), dtype=PETSc.IntType)
    scalar = csr_array((number, columns, pattern.starts), shape=shape)
    return csr_array(scalar[np.repeat(np.arange(count), dim)])


def _components(rows: csr_array, dim: int) -> Ints:
    """Return the component of each entry of repeated rows."""
    return np.repeat(np.arange(rows.shape[0]) % dim, np.diff(rows.indptr))


def _matrix(
    pattern: Pattern, data: Floats, indices: Ints, indptr: Ints, dim: int, comm: Any
) -> Any:
    """Return the matrix of the rows in columns of this rank, then in those of other ranks."""
    rows = (len(indptr) - 1) // 2
    inner = int(indptr[rows])
    indices = indices.astype(PETSc.IntType, copy=False)
    indices[:inner] -= dim * pattern.first
    return from_blocks(
        (indptr[: rows + 1], indices[:inner], data[:inner]),
        (indptr[rows:] - inner, indices[inner:], data[inner:]),
        comm,
        block_size=dim,
    )
