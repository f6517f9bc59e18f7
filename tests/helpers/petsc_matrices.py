"""PETSc matrices from scipy and numpy ones, and back."""

import numpy as np
from scipy.sparse import csr_array

from cea.petsc import PETSc


def to_petsc(matrix):
    """PETSc AIJ matrix on this rank."""
    matrix = csr_array(matrix)
    return PETSc.Mat().createAIJ(
        matrix.shape,
        csr=(
            matrix.indptr.astype(PETSc.IntType),
            matrix.indices.astype(PETSc.IntType),
            matrix.data,
        ),
        comm=PETSc.COMM_SELF,
    )


def to_scipy(matrix):
    """CSR array of a PETSc AIJ matrix on one rank."""
    starts, columns, values = matrix.getValuesCSR()
    return csr_array((values, columns, starts), shape=matrix.getSize())


def to_numpy(matrix):
    """Dense array of a PETSc AIJ matrix on one rank."""
    return np.asarray(to_scipy(matrix).toarray())
