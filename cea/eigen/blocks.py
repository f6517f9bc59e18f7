"""Products with tall blocks of vectors in Fortran order, real or complex, the rows of each rank.

Matrices are applied to some columns at a time: nothing of the size of all vectors is kept beside
them. A tall block is read once for each product, without copies in another order.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dgemm, zgemm

from cea.arrays import Floats
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


def combined(vectors: NDArray[Any], coefficients: NDArray[Any]) -> NDArray[Any]:
    """Vectors times coefficients, a new block in Fortran order.

    Parameters
    ----------
    vectors
        In Fortran order, shape (n, k).
    coefficients
        Real or complex, shape (k, columns).
    """
    if np.iscomplexobj(coefficients) and not np.iscomplexobj(vectors):
        result = np.empty((len(vectors), coefficients.shape[1]), dtype=complex, order="F")
        result.real = combined(vectors, coefficients.real)
        result.imag = combined(vectors, coefficients.imag)
        return result
    return (coefficients.T @ vectors.T).T


def inner(left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """Inner products of every column of one block with every column of another.

    The right is best the smaller: the left is then read at the speed of memory.
    """
    products = right.conj().T @ left if np.iscomplexobj(right) else right.T @ left
    return products.conj().T if np.iscomplexobj(products) else products.T


def beside(left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """Two blocks as one, in Fortran order; the right itself where the left is empty."""
    columns = left.shape[1]
    if not columns and right.flags.f_contiguous:
        return right
    shape = (len(left), columns + right.shape[1])
    both: NDArray[Any] = np.empty(shape, dtype=np.result_type(left, right), order="F")
    both[:, :columns], both[:, columns:] = left, right
    return both


def subtract(block: NDArray[Any], vectors: NDArray[Any], coefficients: NDArray[Any]) -> None:
    """Subtract vectors times coefficients from a block, in place.

    Parameters
    ----------
    block
        In Fortran order, shape (n, columns).
    vectors, coefficients
        Of the type of the block, shapes (n, k), in Fortran order, and (k, columns).
    """
    if not (vectors.size and block.size):
        return
    product = zgemm if np.iscomplexobj(block) else dgemm
    result = product(-1.0, vectors, coefficients, beta=1.0, c=block, overwrite_c=True)
    if not np.shares_memory(result, block):
        block[:] = result
