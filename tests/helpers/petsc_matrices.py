"""PETSc matrices from scipy and numpy ones, and back; pencils as dense matrices."""

import numpy as np
from scipy.linalg import eigvals
from scipy.sparse import csr_array

from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.pencil import Pencil, Term
from cea.matrices import distributed
from cea.petsc import PETSc


def to_petsc(matrix):
    """PETSc AIJ matrix on this rank."""
    return distributed(csr_array(matrix), np.shape(matrix), PETSc.COMM_SELF)


def to_scipy(matrix):
    """CSR array of a PETSc AIJ matrix on one rank."""
    starts, columns, values = matrix.getValuesCSR()
    return csr_array((values, columns, starts), shape=matrix.getSize())


def to_numpy(matrix):
    """Dense array of a PETSc AIJ matrix on one rank."""
    return np.asarray(to_scipy(matrix).toarray())


FRICTION = "friction"
"""Factor on the friction matrix of :func:`sliding_pencil`."""


def sliding_pencil(stiffness, mass, friction):
    """Pencil lambda^2 M + K - s F of arrays, K symmetric, s the factor of friction."""
    factor = Coefficient({FRICTION: (1.0, 1.0)}, factor=-1.0)
    terms = [
        Term("stiffness", to_petsc(stiffness)),
        Term("mass", to_petsc(mass)),
        Term("stiffness", to_petsc(friction), factor, symmetric=False),
    ]
    return Pencil(terms, [Parameter(FRICTION, 1.0)])


def dense_pencil(matrices):
    """M, D and K of a pencil as dense arrays, contact forces eliminated."""
    K = to_numpy(matrices.operator())
    if (forces := matrices.multipliers) is not None:
        J, L, C = (to_numpy(m) for m in (forces.closure, forces.reaction, forces.compliance))
        K += L.T @ np.linalg.solve(C, J)
    D = np.zeros_like(K)
    for part in (matrices.damping, matrices.gyroscopic):
        if part is not None:
            D += to_numpy(part)
    if (piece := matrices.low_rank) is not None:
        D += piece.vectors @ piece.vectors.T
    return to_numpy(matrices.mass), D, K


def quadratic_eigenvalues(M, D, K):
    """Every lambda of lambda^2 M + lambda D + K, dense."""
    n, K, D = len(M), np.linalg.solve(M, K), np.linalg.solve(M, D)
    size = np.sqrt(np.abs(K).max())
    low = np.hstack([-K / size**2, -D / size])
    return size * eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [low]]))


def gather(vector):
    """Whole PETSc vector on every rank."""
    return np.concatenate(vector.comm.tompi4py().allgather(vector.array_r))
