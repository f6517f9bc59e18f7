"""Which eigenvalues a window of a damped pencil may hold: how fast they may grow.

For an eigenvalue g + i w with its vector x, the real part of x^H P(lambda) x = 0 is

    x^H ((g^2 - w^2) M + g C + H) x + w Im(x^H Y x) = 0

with the symmetric parts C of the damping and H of K, and the skew part Y. With abs(x^H Y x) below
x^H diag(y) x, y the row sums of abs(Y), no eigenvalue with abs(w) <= omega grows at the rate g
where

    H + (g^2 - omega^2) M + g C - omega diag(y)

has no negative eigenvalue: its inertia tells. It has none for any larger g either, if 2 g M + C
has none; where C damps, it has not.
"""

from typing import Any

import numpy as np

from cea.eigen.factorisation import Mumps
from cea.eigen.field_of_values import factorised_hermitian, hermitian_part
from cea.eigen.pencil import Matrices
from cea.matrices import destroy, local_part, scaled_total
from cea.petsc import PETSc

_DIFFERENT: Any = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN


def bounded_growth(matrices: Matrices, growth: float, end: float) -> bool:
    """Whether no eigenvalue with abs(Im lambda) <= end can grow at a rate or faster.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    growth
        g (1/s).
    end
        omega (1/s).

    Raises
    ------
    ConvergenceError
        When a factorisation fails.
    """
    damping = _symmetric_damping(matrices)
    if damping is not None and not _monotonic(matrices, damping, growth):
        destroy(damping)
        return False
    hermitian = hermitian_part(matrices, growth**2 - end**2)
    if damping is not None:
        hermitian.axpy(growth, damping, structure=_DIFFERENT)
        destroy(damping)
    if matrices.gyroscopic is not None:
        diagonal = hermitian.getDiagonal()
        diagonal.array[:] -= end * _skew_row_sums(matrices.gyroscopic)
        hermitian.setDiagonal(diagonal)
        hermitian.assemble()
        destroy(diagonal)
    factors, bounded = factorised_hermitian(hermitian, matrices)
    if factors is not None:
        factors.free()
    return bounded


def _symmetric_damping(matrices: Matrices) -> Any | None:
    """Symmetric part of C + Y, a new matrix; None without."""
    parts = [] if matrices.damping is None else [(1.0, matrices.damping)]
    if matrices.gyroscopic is None:
        return scaled_total(parts) if parts else None
    transpose = matrices.gyroscopic.transpose(PETSc.Mat())
    total = scaled_total([*parts, (0.5, matrices.gyroscopic), (0.5, transpose)])
    destroy(transpose)
    return total


def _monotonic(matrices: Matrices, damping: Any, growth: float) -> bool:
    """Whether 2 g M + C has no negative eigenvalue."""
    factors = Mumps(
        scaled_total([(2 * growth, matrices.mass), (1.0, damping)]), symmetric=True, inertia=True
    )
    negative = factors.negative_eigenvalues()
    factors.free()
    return negative == 0


def _skew_row_sums(matrix: Any) -> np.ndarray:
    """Row sums of the absolute values of the skew part, the rows of this rank."""
    transpose = matrix.transpose(PETSc.Mat())
    skew = scaled_total([(0.5, matrix), (-0.5, transpose)])
    sums = np.asarray(abs(local_part(skew)).sum(axis=1)).ravel()
    destroy(transpose, skew)
    return sums
