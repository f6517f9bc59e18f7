"""Products of distributed matrices with blocks of vectors, real or complex, the rows of each rank.

A block of columns at a time: nothing of the size of all vectors is kept beside them.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.dense_products import inner
from cea.matrices import dense, destroy

_COLUMNS = 64
"""Columns at a time."""
_NUMBERS, _LEAST = 800_000, 8
"""Numbers that are worked on at a time, and least columns of them: memory of few is used again and
stays near, that of many is asked for anew each time."""


def column_blocks(columns: int, rows: int = 0) -> Iterator[slice]:
    """Slices of so many columns as are worked on at a time.

    Parameters
    ----------
    columns
        Their number.
    rows
        Rows over all ranks: of long columns fewer are taken. That is for products and sums;
        solves are cheaper the more columns they have.
    """
    at_once = min(_COLUMNS, _few(rows)) if rows else _COLUMNS
    for start in range(0, columns, at_once):
        yield slice(start, min(start + at_once, columns))


def _few(rows: int) -> int:
    """Columns of so many rows that stay near: a multiple of those of one pass of a product."""
    return max(_LEAST, _NUMBERS // rows // _LEAST * _LEAST)


def times(matrix: Any, vectors: NDArray[Any]) -> NDArray[Any]:
    """Matrix times a block of vectors, real and imaginary parts side by side."""
    if matrix.getSize()[0] != matrix.getSize()[1] and matrix.comm.size > 1:
        x, y = matrix.createVecRight(), matrix.createVecLeft()
        return _one_by_one(matrix.mult, x, y, vectors)
    if not np.iscomplexobj(vectors):
        return image_of(matrix, vectors)
    rows, n = vectors.shape
    parts = np.empty((rows, 2 * n), order="F")
    parts[:, :n], parts[:, n:] = vectors.real, vectors.imag
    result = image_of(matrix, parts)
    image = np.empty((len(result), n), dtype=complex, order="F")
    image.real, image.imag = result[:, :n], result[:, n:]
    return image


def image_of(matrix: Any, vectors: Floats) -> Floats:
    """Matrix times a block of real vectors, in Fortran order; a square one on several ranks."""
    rows, layout = matrix.getSizes()
    image = np.empty((rows[0], vectors.shape[1]), order="F")
    at_once = _few(max(*matrix.getSize(), 1))
    for start in range(0, vectors.shape[1], at_once):
        columns = slice(start, start + at_once)
        block = dense(vectors[:, columns], layout, matrix.comm)
        product = dense(image[:, columns], rows, matrix.comm)
        matrix.matMult(block, product)  # into the memory of the image
        destroy(product, block)
    return image


def transposed_times(matrix: Any, vectors: NDArray[Any]) -> NDArray[Any]:
    """Transposed matrix times a block of vectors."""
    x, y = matrix.createVecLeft(), matrix.createVecRight()
    return _one_by_one(matrix.multTranspose, x, y, vectors)


def _one_by_one(product: Any, x: Any, y: Any, vectors: NDArray[Any]) -> NDArray[Any]:
    """Products column by column, for matMult does not bear ranks with rows and no columns."""
    shape = (y.getLocalSize(), vectors.shape[1])
    image: NDArray[Any] = np.empty(shape, dtype=vectors.dtype, order="F")
    parts = ("real", "imag") if np.iscomplexobj(vectors) else ("real",)
    for i, column in enumerate(vectors.T):
        for part in parts:
            x.array[:] = getattr(column, part)
            product(x, y)
            getattr(image, part)[:, i] = y.array_r
    destroy(x, y)
    return image


def columns_inner(left: NDArray[Any], right: NDArray[Any], comm: Any) -> NDArray[Any]:
    """Inner products of the columns of two blocks, one with one."""
    if np.iscomplexobj(left):
        left = left.conj()
    return comm.tompi4py().allreduce(np.einsum("ij,ij->j", left, right))


def all_inner(left: NDArray[Any], right: NDArray[Any], comm: Any) -> NDArray[Any]:
    """Inner products of every column of one block with every column of another."""
    return comm.tompi4py().allreduce(inner(left, right))


def norms(vectors: NDArray[Any], comm: Any) -> Floats:
    """Lengths of the columns."""
    return np.sqrt(columns_inner(vectors, vectors, comm).real)
