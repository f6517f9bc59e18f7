"""Factorised matrices as drivers solve with them: by own factors, or by those of one nearby."""

import sys
from typing import Any, Protocol

import numpy as np

from cea.arrays import Floats
from cea.matrices import destroy

_SOLVED = 1e-11
"""Relative defect up to which a refined system counts as solved."""


class Factorisation(Protocol):
    """A matrix A that systems can be solved with."""

    def solve(self, b: Any, x: Any, *, transposed: bool = False) -> None:
        """Solve A x = b, or A^T x = b, with PETSc vectors."""
        ...

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """Solve for every column of b: the rows of this rank, shape (n_local, columns)."""
        ...

    def steps(self) -> int:
        """Steps that a system takes."""
        ...

    def free(self) -> None:
        """Free the factors."""
        ...


class Refined:
    """A matrix solved by the factors of a nearby one and steps of iterative refinement.

    Each step leaves the part |I - F^-1 A| of an error: few steps suffice where F is near A.

    Parameters
    ----------
    matrix
        A, PETSc AIJ; it is destroyed with this object, the factors are not.
    near
        Factors of a matrix F near A.
    """

    _MOST_STEPS = 12
    _ROUNDING = 1e-15

    def __init__(self, matrix: Any, near: Factorisation) -> None:
        self.matrix = matrix
        self._near = near
        self._defect, self._correction = matrix.createVecs()

    def solve(self, b: Any, x: Any, *, transposed: bool = False) -> None:
        """Solve A x = b, or A^T x = b, with PETSc vectors, until rounding ends the progress."""
        self._refine(b, x, transposed=transposed)

    def _refine(self, b: Any, x: Any, *, transposed: bool = False) -> tuple[int, float]:
        """Steps taken, and the norm of the defect relative to that of b."""
        times = self.matrix.multTranspose if transposed else self.matrix.mult
        size, before = max(b.norm(), np.finfo(float).tiny), np.inf
        self._near.solve(b, x, transposed=transposed)
        for step in range(self._MOST_STEPS):
            times(x, self._defect)
            self._defect.aypx(-1.0, b)
            norm = self._defect.norm() / size
            if norm <= self._ROUNDING or norm > 0.5 * before:
                return step, norm
            self._near.solve(self._defect, self._correction, transposed=transposed)
            x.axpy(1.0, self._correction)
            before = norm
        return self._MOST_STEPS, before

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """Solve for every column of b: the rows of this rank, shape (n_local, columns)."""
        return _column_by_column(self, b, transposed=transposed)

    def steps(self) -> int:
        """Steps that a system of random numbers takes; very many where it is not solved."""
        x, b = self.matrix.createVecs()
        b.setRandom()
        steps, defect = self._refine(b, x)
        destroy(x, b)
        return steps if defect <= _SOLVED else sys.maxsize

    def free(self) -> None:
        """Free all but the factors."""
        destroy(self._defect, self._correction, self.matrix)


class Applied:
    """A factorisation as the context of a PETSc preconditioner.

    Parameters
    ----------
    factors
        What solves.
    transposed
        Whether it is the transposed matrix that is meant.
    """

    def __init__(self, factors: Factorisation, *, transposed: bool = False) -> None:
        self._factors, self._transposed = factors, transposed

    def apply(self, _: Any, b: Any, x: Any) -> None:
        """Solve with the matrix."""
        self._factors.solve(b, x, transposed=self._transposed)

    def applyTranspose(self, _: Any, b: Any, x: Any) -> None:
        """Solve with the transposed matrix."""
        self._factors.solve(b, x, transposed=not self._transposed)


def _column_by_column(factors: Refined, b: Floats, *, transposed: bool) -> Floats:
    x, right = factors.matrix.createVecs()
    columns = np.empty_like(b)
    for i, column in enumerate(b.T):
        right.array[:] = column
        factors.solve(right, x, transposed=transposed)
        columns[:, i] = x.array_r
    destroy(x, right)
    return columns
