"""Products of distributed matrices with blocks of complex vectors, the rows of each rank.

A block of columns at a time: nothing of the size of all vectors is kept beside them.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.body import Complexes, Floats
from cea.matrices import dense, destroy

_COLUMNS = 64
"""Columns at a time."""


def column_blocks(columns: int) -> Iterator[slice]:
    """Slices of so many columns as are worked on at a time."""
    for start in range(0, columns, _COLUMNS):
        yield slice(start, min(start + _COLUMNS, columns))


def times(matrix: Any, vectors: Complexes) -> Complexes:
    """Matrix times a block of vectors, real and imaginary parts in one sparse-dense product."""
    if matrix.getSize()[0] != matrix.getSize()[1]:
        x, y = matrix.createVecRight(), matrix.createVecLeft()
        return _one_by_one(matrix.mult, x, y, vectors)
    n = vectors.shape[1]
    parts = dense(np.hstack([vectors.real, vectors.imag]), matrix.getSizes()[1], matrix.comm)
    product = matrix.matMult(parts)
    result = product.getDenseArray()
    image = result[:, :n] + 1j * result[:, n:]
    destroy(product, parts)
    return image


def image_of(matrix: Any, vectors: Floats) -> Floats:
    """Square matrix times a block of real vectors, in one product, in Fortran order."""
    block = dense(vectors, matrix.getSizes()[1], matrix.comm)
    product = matrix.matMult(block)
    image: Floats = product.getDenseArray().copy(order="F")
    destroy(product, block)
    return image


def transposed_times(matrix: Any, vectors: Complexes) -> Complexes:
    """Transposed matrix times a block of vectors."""
    x, y = matrix.createVecLeft(), matrix.createVecRight()
    return _one_by_one(matrix.multTranspose, x, y, vectors)


def _one_by_one(product: Any, x: Any, y: Any, vectors: Complexes) -> Complexes:
    """Products column by column, for matMult does not bear ranks with rows and no columns."""
    image = np.empty((y.getLocalSize(), vectors.shape[1]), dtype=complex)
    for i, column in enumerate(vectors.T):
        for part in ("real", "imag"):
            x.array[:] = getattr(column, part)
            product(x, y)
            getattr(image, part)[:, i] = y.array_r
    destroy(x, y)
    return image


def columns_inner(left: Complexes, right: Complexes, comm: Any) -> Complexes:
    """Inner products of the columns of two blocks, one with one."""
    return comm.tompi4py().allreduce(np.einsum("ij,ij->j", left.conj(), right))


def all_inner(left: NDArray[Any], right: NDArray[Any], comm: Any) -> NDArray[Any]:
    """Inner products of every column of one block with every column of another."""
    return comm.tompi4py().allreduce(left.conj().T @ right)


def norms(vectors: Complexes, comm: Any) -> Floats:
    """Lengths of the columns."""
    return np.sqrt(columns_inner(vectors, vectors, comm).real)
