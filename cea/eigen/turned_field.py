"""Where friction can move eigenvalues under stiff contact: a bound by turned test functions.

For any S an eigenpair has x^H S^T (K - kappa M) x = 0. With h, g the parts of x^H S^T K x and
x^H S^T M x that the symmetric parts of these matrices make, and i n that of the skew part of
S^T M, the real part of this is

    h = g Re kappa - n Im kappa.

Where h >= -X g, g > 0 and abs(n) <= tau g for every x, every eigenvalue lies in the wedge

    Re kappa >= -X - tau abs(Im kappa).

With S = 1 that is the bound of Bendixson, tau = 0, and X grows with the stiffness P of a contact:
what friction adds to the symmetric part is of the size of mu P. The S of :mod:`cea.eigen.turn`
makes the stiffness of a contact symmetric, but for what its normal and the direction of friction
vary within an element, and X is of the size of the window for P that are orders larger. Contact
forces f that are unknowns see L S in the place of L, for x^H S^T L^T f = (L S x)^H f.

In the window abs(Im kappa) <= 2 omega sqrt(omega^2 - Re kappa). There r = -Re kappa obeys
r - 2 tau omega sqrt(omega^2 + r) <= X, of which the left side rises with r from where
omega^2 + r = tau^2 omega^2: no eigenvalue of the window lies left of Re kappa = -Y with

    X = Y - 2 tau omega sqrt(omega^2 + Y),     tau^2 omega^2 <= omega^2 + Y.
"""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from cea.eigen.coverage import TIP
from cea.eigen.field_of_values import SAFETY, factorised_hermitian, largest_quotient
from cea.eigen.multipliers import Multipliers
from cea.eigen.pencil import Matrices
from cea.eigen.turn import turn_of
from cea.matrices import destroy, distributed, local_part, symmetrised, transposed_product

_ROUNDING = 1e-12
"""What turning leaves of friction, relative to the largest entry of its row, that is rounding."""


@dataclass(frozen=True)
class TurnedField:
    """What contains x^H S^T K x / x^H S^T M x, for all x, and with it every eigenvalue.

    Parameters
    ----------
    matrices
        The pencil at given parameters; of its contact forces the reaction is L S.
    turn
        S, PETSc AIJ.
    slope
        tau.
    """

    matrices: Matrices
    turn: Any
    slope: float

    @classmethod
    def of(cls, matrices: Matrices, top: float) -> Self | None:
        """S and tau of a pencil; collective.

        Parameters
        ----------
        matrices
            The pencil at given parameters.
        top
            omega^2, the end of the window (1/s^2).

        Returns
        -------
        TurnedField or None
            None where there is no S, or S^T M has no positive definite symmetric part.

        Raises
        ------
        ConvergenceError
            When a factorisation fails.
        """
        turn = turn_of(matrices, top)
        if turn is None:
            return None
        mass = transposed_product(turn, matrices.mass)
        symmetric = symmetrised(mass.copy())
        factors, positive = factorised_hermitian(symmetric, replace(matrices, multipliers=None))
        assert factors is not None
        slope = np.inf
        if positive and not factors.null_pivots():
            slope = SAFETY * largest_quotient(factors, mass)
        factors.free()
        destroy(mass)
        if not np.isfinite(slope):
            destroy(turn)
            return None
        forces = matrices.multipliers
        turned = None if forces is None else replace(forces, reaction=_turned(forces, turn))
        return cls(replace(matrices, multipliers=turned), turn, slope)

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
        within = self._depth_within(top, depth)
        if within is None:
            return False
        operator = self.matrices.operator(-within)
        product = transposed_product(self.turn, operator)
        destroy(operator)
        factors, bounded = factorised_hermitian(symmetrised(product), self.matrices)
        if factors is not None:
            factors.free()
        return bounded

    def _depth_within(self, top: float, depth: float) -> float | None:
        """X of a wedge that the window leaves at a depth Y; None where there is none."""
        tip, square = TIP * top, self.slope**2
        within = depth - 2 * np.sqrt(square * tip * (tip + depth))
        return float(within) if within >= 0 and square * tip <= tip + depth else None

    def free(self) -> None:
        """Free S, and what was made of contact forces."""
        destroy(self.turn)
        if self.matrices.multipliers is not None:
            destroy(self.matrices.multipliers.reaction)


def _turned(forces: Multipliers, turn: Any) -> Any:
    """L S, with the entries of J where it differs from them by rounding."""
    product = forces.reaction.matMult(turn)
    closure, reaction = local_part(forces.closure), local_part(product)
    left = (reaction - closure).tocoo()
    size = abs(closure).max(axis=1).toarray().ravel()
    left.data[np.abs(left.data) <= _ROUNDING * size[left.row]] = 0.0
    destroy(product)
    return distributed(closure + left.tocsr(), forces.closure.getSizes()[1], forces.closure.comm)
