"""Products of tall blocks of vectors, in Fortran order and without copies.

A tall block is read once for each product, and that is what a product costs: numpy would add a
copy in another order, or another block for a difference.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dgemm, zgemm


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
