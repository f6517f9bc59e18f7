"""Which eigenvalues a window of a damped pencil may hold: how fast they may grow.

With x^H M x = 1 let h + i n be x^H K x and c + i y be x^H (C + Y) x. An eigenvalue lambda = g + i w
obeys x^H P(lambda) x = 0, of which the real part, as it is and divided by lambda, is

    g^2 - w^2 + g c - w y + h = 0,       g (abs(lambda)^2 + h) + c abs(lambda)^2 + w n = 0.

The first: with y the row sums of abs(Y), no eigenvalue with abs(w) <= omega grows at the rate g
where H + (g^2 - omega^2) M + g C - omega diag(y) has no negative eigenvalue, nor faster if
2 g M + C has none. The second: where h >= -X, c >= -d, and abs(n) <= t (h + X), the cone of
:mod:`cea.eigen.field_of_values`,

    g <= max(t omega + 2 d, sqrt(2 X)).

The gyroscopic matrix does not enter it. H and C are symmetric parts, Y the skew one. Pieces of C of
low rank are positive semidefinite: both hold for the sum where they hold without them.
"""

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.eigen.field_of_values import factorised_hermitian, field_of_values, hermitian_part
from cea.eigen.mumps import Mumps
from cea.eigen.pencil import Matrices
from cea.matrices import destroy, distributed, local_part, scaled_total
from cea.petsc import PETSc

_DIFFERENT: Any = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN

_SHIFT = 0.25
"""Real part of the first shift relative to omega, where growth may be large."""
_FARTHEST_SHIFT = 0.5
"""The same where one disc then holds all that may grow."""
_LEAST_SHIFT = 0.1
"""The least: a shift is no eigenvalue of those that hardly grow."""
_DEPTH = 0.02
"""X of the cone relative to omega^2."""
_NEGATIVE = (1e-6, 1e-2, 0.1)
"""Negative damping d relative to omega that is tried: none but for rounding, and some."""


def largest_growth(matrices: Matrices, end: float) -> float:
    """Rate (1/s) that no eigenvalue with abs(Im lambda) <= end exceeds, by the cone; or infinity.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    end
        omega (1/s).

    Raises
    ------
    ConvergenceError
        When a factorisation fails.
    """
    field = field_of_values(matrices, _DEPTH * end**2, cone=True)
    if not field.bounded or not np.isfinite(field.slope):
        return np.inf
    damping, least = _symmetric_damping(matrices), 0.0
    if damping is not None:
        tried = (part * end for part in _NEGATIVE)
        least = next((d for d in tried if _positive(matrices, damping, d)), np.inf)
        destroy(damping)
    return max(field.slope * end + 2 * least, float(np.sqrt(2 * field.depth)))


def first_shift(largest: float, left: float, end: float) -> float:
    """Real part (1/s) of the first shift: the disc about it holds all that may grow, or much of it.

    Parameters
    ----------
    largest
        Rate (1/s) that no eigenvalue exceeds.
    left
        Real part at which the window begins (1/s).
    end
        omega (1/s).
    """
    centre = max(_LEAST_SHIFT * end, 0.5 * (largest + left))
    return centre if centre <= _FARTHEST_SHIFT * end else _SHIFT * end


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
    if damping is not None and not _positive(matrices, damping, 2 * growth):
        destroy(damping)
        return False
    hermitian = hermitian_part(matrices, growth**2 - end**2)
    if damping is not None:
        hermitian.axpy(growth, damping, structure=_DIFFERENT)
        destroy(damping)
    if matrices.gyroscopic is not None:
        sums = _skew_row_sums(matrices.gyroscopic)
        hermitian.axpy(-end, sums, structure=_DIFFERENT)
        destroy(sums)
    factors, bounded = factorised_hermitian(hermitian, matrices, circulatory=True)
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


def _positive(matrices: Matrices, damping: Any, rate: float) -> bool:
    """Whether C + rate M has no negative eigenvalue."""
    factors = Mumps(
        scaled_total([(rate, matrices.mass), (1.0, damping)]), symmetric=True, inertia=True
    )
    negative = factors.negative_eigenvalues()
    factors.free()
    return negative == 0


def _skew_row_sums(matrix: Any) -> Any:
    """Diagonal matrix of the row sums of the absolute values of the skew part, PETSc AIJ."""
    transpose = matrix.transpose(PETSc.Mat())
    skew = scaled_total([(0.5, matrix), (-0.5, transpose)])
    sums = np.asarray(abs(local_part(skew)).sum(axis=1)).ravel()
    rows, columns = skew.getSizes()
    start, stop = skew.getOwnershipRange()
    diagonal = csr_array((sums, np.arange(start, stop), np.arange(rows[0] + 1)), (rows[0], rows[1]))
    destroy(transpose, skew)
    return distributed(diagonal, columns, matrix.comm)
