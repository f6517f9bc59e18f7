"""Where friction can move eigenvalues under stiff contact: a bound by turned test functions.

For any S an eigenpair has x^H S^T (K - kappa M) x = 0. With h, g the parts of x^H S^T K x and
x^H S^T M x that the symmetric parts of these matrices make, and i n that of the skew part of
S^T M, the real part of this is

    h = g Re kappa - n Im kappa.

Where h >= -X g, g > 0 and abs(n) <= tau g for every x, every eigenvalue lies in the wedge

    Re kappa >= -X - tau abs(Im kappa).

With S = 1 that is the bound of Bendixson, tau = 0, and X grows with the stiffness P of a contact:
what friction adds to the symmetric part is of the size of mu P. The test functions of
:mod:`cea.eigen.turned_tests` make the stiffness of a contact symmetric, and X is of the size of
the window whatever P.

In the window abs(Im kappa) <= 2 omega sqrt(omega^2 - Re kappa). There r = -Re kappa obeys
r - 2 tau omega sqrt(omega^2 + r) <= X, of which the left side rises with r from where
omega^2 + r = tau^2 omega^2: no eigenvalue of the window lies left of Re kappa = -Y with

    X = Y - 2 tau omega sqrt(omega^2 + Y),     tau^2 omega^2 <= omega^2 + Y.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from cea.eigen.coverage import TIP
from cea.eigen.mumps import Mumps
from cea.eigen.pencil import Matrices
from cea.eigen.turn import turn_of
from cea.eigen.turned_mass import skewness
from cea.eigen.turned_tests import TurnedTests
from cea.matrices import destroy

_WEIGHTS = (1.0, 1e2, 1e4)
"""Weights s on what mends the turn that are tried, until S^T M is positive definite."""


@dataclass(frozen=True)
class TurnedField:
    """What contains x^H S^T K x / x^H S^T M x, for all x, and with it every eigenvalue.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    tests
        S.
    slope
        tau.
    """

    matrices: Matrices
    tests: TurnedTests
    slope: float

    @classmethod
    def of(cls, matrices: Matrices) -> Self | None:
        """S and tau of a pencil; collective.

        Parameters
        ----------
        matrices
            The pencil at given parameters.

        Returns
        -------
        TurnedField or None
            None without friction, where it is not known which unknowns belong together, where
            closures depend on each other, or S^T M has no positive definite symmetric part.

        Raises
        ------
        ConvergenceError
            When a factorisation fails.
        """
        if matrices.multipliers is not None and matrices.multipliers.dependent:
            return None
        turn = turn_of(matrices)
        if turn is None:
            return None
        for weight in _WEIGHTS:
            tests = TurnedTests.of(matrices, turn, weight)
            slope = skewness(tests, matrices.mass)
            if slope is not None:
                return cls(matrices, tests, slope)
            tests.free()
        turn.free()
        return None

    def bounds(self, top: float, depth: float) -> bool:
        """Whether no eigenvalue of a window has Re kappa < -depth; collective.

        Parameters
        ----------
        top
            omega^2, the end of the window (1/s^2).
        depth
            Y (1/s^2).

        Raises
        ------
        ConvergenceError
            When the factorisation fails.
        """
        within = self.depth_within(top, depth)
        return within is not None and self.holds(within)

    def holds(self, within: float) -> bool:
        """Whether h >= -X g for every x; collective.

        Parameters
        ----------
        within
            X (1/s^2).

        Raises
        ------
        ConvergenceError
            When the factorisation fails.
        """
        operator = self.matrices.operator(-within)
        product = self.tests.product(operator)
        destroy(operator)
        whole = self.tests.symmetric(product, forces=True)
        product.free()
        factors = Mumps(whole, symmetric=True, inertia=True)
        expected = self.tests.constraints + self.tests.forces
        shown = factors.negative_eigenvalues() == expected and not factors.null_pivots()
        factors.free()
        return shown

    def depth_within(self, top: float, depth: float) -> float | None:
        """X of a wedge that the window leaves at a depth Y (1/s^2); None where there is none.

        Parameters
        ----------
        top, depth
            As of :meth:`bounds`.
        """
        tip, square = TIP * top, self.slope**2
        within = depth - 2 * np.sqrt(square * tip * (tip + depth))
        return float(within) if within >= 0 and square * tip <= tip + depth else None

    def free(self) -> None:
        """Free S."""
        self.tests.free()
        self.tests.turn.free()
