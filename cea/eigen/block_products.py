"""Products with tall blocks of vectors in Fortran order, real or complex, the rows of each rank.

Matrices are applied to a few columns at a time, to avoid temporaries of the size of the block. A
block is read once for each product, without copies in another order.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.matrices import dense, destroy

_COLUMNS = 64
"""Largest number of columns in one product."""


def column_blocks(columns: int) -> Iterator[slice]:
    """Yield slices of columns, each for one product."""
    for start in range(0, columns, _COLUMNS):
        yield slice(start, min(start + _COLUMNS, columns))


def by_parts(product: Callable[[Floats], Floats], block: NDArray[Any]) -> NDArray[Any]:
    """Apply a real product to a block; of complex vectors to both parts side by side."""
    if not np.iscomplexobj(block):
        return product(block)
    n = block.shape[1]
    both = product(np.asfortranarray(np.hstack([block.real, block.imag])))
    image = np.empty((len(both), n), dtype=complex, order="F")
    image.real, image.imag = both[:, :n], both[:, n:]
    return image


def times(matrix: Any, vectors: NDArray[Any]) -> NDArray[Any]:
    """Return a matrix times a block of vectors, in Fortran order."""
    return by_parts(partial(_times, matrix), vectors)


def _times(matrix: Any, vectors: Floats) -> Floats:
    ranges = matrix.getOwnershipRanges(), matrix.getOwnershipRangesColumn()
    if matrix.comm.size > 1 and not np.array_equal(*ranges):
        return _one_by_one(matrix.mult, matrix.createVecRight(), matrix.createVecLeft(), vectors)
    rows, layout = matrix.getSizes()
    image = np.empty((rows[0], vectors.shape[1]), order="F")
    for columns in column_blocks(vectors.shape[1]):
        block = dense(vectors[:, columns], layout, matrix.comm)
        product = dense(image[:, columns], rows, matrix.comm)
        matrix.matMult(block, product)  # into the memory of the image
        destroy(product, block)
    return image


def transposed_times(matrix: Any, vectors: NDArray[Any]) -> NDArray[Any]:
    """Return a transposed matrix times a block of vectors."""
    x, y = matrix.createVecLeft(), matrix.createVecRight()
    return by_parts(partial(_one_by_one, matrix.multTranspose, x, y), vectors)


def _one_by_one(product: Any, x: Any, y: Any, vectors: Floats) -> Floats:
    """Compute products column by column, since matMult fails on ranks with rows and no columns."""
    image = np.empty((y.getLocalSize(), vectors.shape[1]), order="F")
    for i, column in enumerate(vectors.T):
        x.array[:] = column
        product(x, y)
        image[:, i] = y.array_r
    destroy(x, y)
    return image


def columns_inner(left: NDArray[Any], right: NDArray[Any], comm: Any) -> NDArray[Any]:
    """Return the inner products of corresponding columns of two blocks."""
    return comm.tompi4py().allreduce(np.einsum("ij,ij->j", left.conj(), right))


def all_inner(left: NDArray[Any], right: NDArray[Any], comm: Any) -> NDArray[Any]:
    """Return the inner products of every column of one block with every column of another.

    It is fastest if the right block is the smaller one.
    """
    products = right.conj().T @ left if np.iscomplexobj(right) else right.T @ left
    products = products.conj().T if np.iscomplexobj(products) else products.T
    return comm.tompi4py().allreduce(products)


def norms(vectors: NDArray[Any], comm: Any) -> Floats:
    """Return the Euclidean norms of the columns."""
    return np.sqrt(columns_inner(vectors, vectors, comm).real)


def combined(vectors: NDArray[Any], coefficients: NDArray[Any]) -> NDArray[Any]:
    """Return vectors times real or complex coefficients, both blocks in Fortran order."""
    if np.iscomplexobj(coefficients) and not np.iscomplexobj(vectors):
        result = np.empty((len(vectors), coefficients.shape[1]), dtype=complex, order="F")
        result.real = combined(vectors, coefficients.real)
        result.imag = combined(vectors, coefficients.imag)
        return result
    return (coefficients.T @ vectors.T).T


def beside(left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """Join two blocks in Fortran order; return the right one itself where the left is empty."""
    columns = left.shape[1]
    if not columns and right.flags.f_contiguous:
        return right
    shape = (len(left), columns + right.shape[1])
    both: NDArray[Any] = np.empty(shape, dtype=np.result_type(left, right), order="F")
    both[:, :columns], both[:, columns:] = left, right
    return both
