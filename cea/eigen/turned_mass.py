"""The mass in turned test functions: its skew part relative to its symmetric one."""

from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.blocks import image_of, times, transposed_times
from cea.eigen.field_of_values import SAFETY, largest_quotient
from cea.eigen.mumps import Mumps
from cea.eigen.turned_tests import TurnedTests

_STEPS = 12
"""Steps of block Krylov. From random vectors k steps leave about 0.1 (ln(n) / k)^2 of an extreme
eigenvalue however close others are (Kuczynski, Wozniakowski, SIAM J. Matrix Anal. Appl. 13, 1992):
the safety covers it."""


class TurnedMass:
    """(S + N Z)^T M on blocks of vectors, the rows of this rank; Z is what makes z of x.

    Parameters
    ----------
    tests
        The test functions.
    mass
        M, PETSc AIJ, symmetric positive definite.

    Raises
    ------
    ConvergenceError
        When Q is singular.
    """

    def __init__(self, tests: TurnedTests, mass: Any) -> None:
        self._turn, self._outer, self._mass = tests.turn, tests.outer, mass
        self._inner = Mumps(tests.inner.copy(), symmetric=True)

    def image(self, x: Floats) -> Floats:
        """Its symmetric part times x."""
        forward, back = self._both(x)
        return np.asfortranarray(0.5 * (forward + back))

    def skew(self, x: Floats) -> Floats:
        """Its skew part times x."""
        forward, back = self._both(x)
        return np.asfortranarray(0.5 * (forward - back))

    def _both(self, x: Floats) -> tuple[Floats, Floats]:
        """The matrix, and its transpose, times x."""
        normals, outer = self._turn.normals, self._outer
        moved = image_of(self._mass, x)
        along = transposed_times(normals, moved)
        pushed = np.zeros((outer.getLocalSize()[0], x.shape[1]), order="F")
        pushed[: len(along)] = along
        forward = image_of(self._turn.matrix, moved)
        forward += transposed_times(outer, self._inner.solve_block(pushed))
        mended = self._inner.solve_block(np.asfortranarray(times(outer, x)))[: len(along)]
        tested = image_of(self._turn.matrix, x) + times(normals, mended)
        return forward, image_of(self._mass, tested)

    def free(self) -> None:
        """Free the factors."""
        self._inner.free()


def skewness(tests: TurnedTests, mass: Any) -> float | None:
    """Estimate of tau, with a safety of one half; None without a positive definite symmetric part.

    Parameters
    ----------
    tests
        The test functions.
    mass
        M, PETSc AIJ.

    Raises
    ------
    ConvergenceError
        When a factorisation fails.
    """
    product = tests.product(mass)
    factors = Mumps(tests.symmetric(product), symmetric=True, inertia=True)
    product.free()
    if factors.negative_eigenvalues() != tests.constraints or factors.null_pivots():
        factors.free()
        return None
    turned = TurnedMass(tests, mass)
    rows = mass.getLocalSize()[0]
    whole = factors.matrix.getLocalSize()[0]

    def solve(load: Floats) -> Floats:
        padded = np.zeros((whole, load.shape[1]), order="F")
        padded[:rows] = load
        return np.asfortranarray(factors.solve_block(padded)[:rows])

    largest = largest_quotient(solve, turned.image, turned.skew, rows, mass.comm, _STEPS)
    turned.free()
    factors.free()
    return SAFETY * largest if np.isfinite(largest) else None
