"""What factors of single precision say for certain: how far they are from the matrix.

Factors of H are exact ones of a matrix F that rounding has parted from it. Where F is positive
definite and

    max abs(x^T (F - H) x) / x^T F x < 1,

H is positive definite too (Bhatia, Positive Definite Matrices, ch. 1). The quotient is that of an
eigenvalue of F^-1 H - 1, and a few steps of a block power iteration with F^-1 H - 1 find the
largest: rounding weighs most on the smooth vectors, which F^-1 brings out at once.
"""

from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.blocks import all_inner, image_of
from cea.eigen.mumps import Mumps

_COLUMNS, _STEPS = 4, 2
"""Columns of the block, and steps."""
_CERTAIN = 1e-2
"""Quotient, estimated from below, up to which factors are trusted: a hundredth of what would do."""
_DEPENDENT = 1e-12
"""Square of a direction, relative to the largest, below which it is not one."""


def shares_inertia(factors: Mumps) -> bool:
    """Whether a symmetric matrix is positive definite as its factors are; collective.

    Parameters
    ----------
    factors
        Positive definite factors of single precision.
    """
    return relative_rounding(factors) <= _CERTAIN


def relative_rounding(factors: Mumps) -> float:
    """Estimate from below of the norm of F^-1 H - 1, in the norm of H; infinite where it has none.

    Parameters
    ----------
    factors
        Factors F of a symmetric matrix H.
    """
    matrix, worst = factors.matrix, 0.0
    rows = matrix.getLocalSize()[0]
    block = np.random.default_rng([2, matrix.comm.rank]).standard_normal((rows, _COLUMNS))
    for _ in range(_STEPS):
        image = image_of(matrix, block)
        squares, axes = np.linalg.eigh(all_inner(block, image, matrix.comm))
        kept = squares > _DEPENDENT * squares.max()
        if not kept.any():
            return np.inf  # not positive definite on this block
        turn = axes[:, kept] / np.sqrt(squares[kept])
        block, image = block @ turn, image @ turn
        block = factors.solve_block(image) - block
        quotient = _largest_square(block, matrix)
        if not np.isfinite(quotient):
            return np.inf
        worst = max(worst, float(np.sqrt(max(quotient, 0.0))))
    return worst


def _largest_square(block: Floats, matrix: Any) -> float:
    """Largest x^T H x of the span of unit combinations of columns."""
    gram = all_inner(block, image_of(matrix, block), matrix.comm)
    return float(np.linalg.eigvalsh(gram).max()) if np.isfinite(gram).all() else np.inf
