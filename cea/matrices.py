"""Small operations on distributed PETSc matrices, used by contact and by the eigensolver."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.petsc import PETSc

type Rows = tuple[NDArray[np.integer[Any]], NDArray[np.integer[Any]], Floats]
"""Matrix in CSR form: row pointers, column indices, values."""


def distributed(
    rows: csr_array, columns: tuple[int, int], comm: Any, *, shared: bool = False
) -> Any:
    """Return a PETSc AIJ matrix of the rows of all ranks, in the order of the ranks."""
    size: Any = ((rows.shape[0], PETSc.DETERMINE), columns)
    starts = rows.indptr.astype(PETSc.IntType, copy=False)
    csr: Any = (starts, rows.indices.astype(PETSc.IntType, copy=False), rows.data)
    if shared and comm.size == 1:
        return PETSc.Mat().createAIJWithArrays(size, csr, comm=comm)
    return PETSc.Mat().createAIJ(size=size, csr=csr, comm=comm)


def from_blocks(inner: Rows, outer: Rows, comm: Any, *, block_size: int | None = None) -> Any:
    """Return a square PETSc AIJ matrix that shares the memory of the rows of each rank."""
    rows = len(inner[0]) - 1
    parts = tuple((starts.astype(PETSc.IntType), *rest) for starts, *rest in (inner, outer))
    csr: Any = parts[0] if comm.size == 1 else parts
    size: Any = ((rows, None), (rows, None))
    return PETSc.Mat().createAIJWithArrays(size, csr, bsize=block_size, comm=comm)


def local_part(matrix: Any) -> csr_array:
    """Return the rows of a PETSc AIJ matrix on this rank, with all columns."""
    start, stop = matrix.getOwnershipRange()
    indptr, indices, values = matrix.getValuesCSR()
    return csr_array((values, indices, indptr), shape=(stop - start, matrix.getSize()[1]))


def one_below_the_other(blocks: Sequence[Any]) -> Any:
    """Stack matrices vertically, PETSc AIJ; each rank holds its rows of each block in turn."""
    return PETSc.Mat().createNest([[block] for block in blocks]).convert("aij")


def side_by_side(blocks: Sequence[Any]) -> Any:
    """Stack matrices horizontally, PETSc AIJ; each rank owns its columns of each block in turn."""
    return PETSc.Mat().createNest([list(blocks)]).convert("aij")


def applied(matrix: Any, values: Floats, *, transposed: bool = False) -> Floats:
    """Multiply a matrix, or its transpose, by a vector; both vectors are the rows of this rank."""
    x, y = matrix.createVecs()
    if transposed:
        x, y = y, x
    x.array[:] = values
    (matrix.multTranspose if transposed else matrix.mult)(x, y)
    image = y.array_r.copy()
    destroy(x, y)
    return image


def diagonal_of(matrix: Any) -> Floats:
    """Return the diagonal of a matrix, the rows of this rank."""
    vector = matrix.getDiagonal()
    values = vector.array_r.copy()
    destroy(vector)
    return values


def product(left: Any, right: Any, factor: Floats) -> Any:
    """Return L^T diag(factor) R; ``factor`` has the rows of this rank."""
    scaled = _with_rows_scaled(right, factor)
    result = _alone(left.transposeMatMult(scaled))
    destroy(scaled)
    return result


def _with_rows_scaled(matrix: Any, factor: Floats) -> Any:
    scaled, vector = matrix.copy(), matrix.createVecLeft()
    vector.array[:] = factor
    scaled.diagonalScale(L=vector)
    destroy(vector)
    return scaled


def times(left: Any, right: Any) -> Any:
    """Return L R."""
    return _alone(left.matMult(right))


def symmetric_product(gap: Any, weight: Floats) -> Any:
    """Return G^T D G as (sqrt(D) G)^T (sqrt(D) G), symmetric to the last bit.

    On several ranks an entry and its transpose may sum the same terms in different order; the mean
    of both is symmetric.
    """
    scaled = _with_rows_scaled(gap, np.sqrt(weight))
    result = _alone(scaled.transposeMatMult(scaled))
    if result.comm.size > 1:
        symmetrised(result)
    result.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    destroy(scaled)
    return result


def _alone(product: Any) -> Any:
    """Copy a product without the references to its factors and transposes that PETSc keeps."""
    result = product.copy()
    destroy(product)
    return result


def symmetrised(matrix: Any, sign: float = 1.0) -> Any:
    """Replace a PETSc AIJ matrix A by (A + sign A^T) / 2, symmetric or skew to the last bit."""
    transpose = matrix.transpose(PETSc.Mat())
    # An entry may be stored while its transpose, an exact zero, was dropped.
    matrix.axpy(sign, transpose, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    matrix.scale(0.5)
    transpose.destroy()
    return matrix


def scaled_total(parts: Sequence[tuple[float, Any]]) -> Any:
    """Return a new matrix, the sum of factors times matrices."""
    factor, first = parts[0]
    result = first.copy()
    if factor != 1:
        result.scale(factor)
    for factor, matrix in parts[1:]:
        result.axpy(factor, matrix, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    return result


def of_entries(function: np.ufunc, matrix: Any) -> Any:
    """Return a function of the stored entries of a PETSc AIJ matrix, as a new matrix."""
    rows = local_part(matrix)
    function(rows.data, out=rows.data)
    return distributed(rows, matrix.getSizes()[1], matrix.comm, shared=True)


def block_diagonal(blocks: Sequence[Any]) -> Any:
    """Return a block diagonal nest of matrices; convert it to AIJ before computing with it."""
    n = len(blocks)
    rows: list[list[Any]] = [[None] * n for _ in blocks]
    for i, block in enumerate(blocks):
        rows[i][i] = block
    return PETSc.Mat().createNest(rows)


def zeros(rows: tuple[int, int], columns: tuple[int, int], comm: Any) -> Any:
    """Return a zero PETSc AIJ matrix; ``rows`` and ``columns`` are local and global sizes."""
    matrix = PETSc.Mat().createAIJ((rows, columns), nnz=0, comm=comm)
    matrix.setUp()
    matrix.assemble()
    return matrix


def identity(rows: int, comm: Any) -> Any:
    """Return an identity, PETSc AIJ, with ``rows`` rows on this rank."""
    layout: Any = ((rows, None), (rows, None))
    return PETSc.Mat().createConstantDiagonal(layout, 1.0, comm=comm).convert("aij")


def dense(columns: NDArray[Any], layout: tuple[int, int], comm: Any) -> Any:
    """Return a PETSc dense matrix that shares the memory of the rows of each rank."""
    size: Any = (layout, (PETSc.DECIDE, columns.shape[1]))
    array: Any = np.asfortranarray(columns)
    return PETSc.Mat().createDense(size, array=array, comm=comm)


def destroy(*objects: Any) -> None:
    """Free PETSc objects immediately; on several ranks garbage collection only defers it."""
    for each in objects:
        each.destroy()
