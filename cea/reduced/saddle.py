"""Contact forces as unknowns of a reduced model, eliminated where it is solved.

    [ K_r    N^T - c_f T^T ] [a]
    [ N     -c_c           ] [b],      N = F^T J V,   T = F^T R V

on a basis V of displacements and a C^-orthonormal one F of forces. With A = K_r + s M_r and
S = c_c + N A^-1 (N^T - c_f T^T),

    (A + contact)^-1 = A^-1 - A^-1 (N^T - c_f T^T) S^-1 N A^-1,    b = S^-1 N A^-1 h

under forces h: nothing grows with the stiffness 1 / c_c, as P N^T N does, in which the gaps that
forces close are differences of large numbers.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, lu_factor, lu_solve

from cea.arrays import Floats
from cea.eigen.parameters import Dependence
from cea.reduced.certificate import Residuals
from cea.reduced.pieces import Values


def padded(coordinates: Floats, rows: int) -> Floats:
    """Coordinates with rows of zeros below, so many in all."""
    return np.pad(coordinates, ((0, rows - len(coordinates)), (0, 0)))


@dataclass(frozen=True)
class SmallContact:
    """A contact on bases of displacements V and forces F, with X^-1-coordinates Q of its forces.

    c_c and c_f, N and T of shape (m, k), Q^T J^T F and Q^T R^T F, norm of what Q does not hold.
    """

    inverse_stiffness: Dependence
    friction: Dependence
    closes: Floats
    slides: Floats
    normal_forces: Floats
    friction_forces: Floats
    lost: float

    def padded(self, rows: int) -> "SmallContact":
        """With zeros for vectors of Q that came later."""
        both = padded(self.normal_forces, rows), padded(self.friction_forces, rows)
        return replace(self, normal_forces=both[0], friction_forces=both[1])


@dataclass(frozen=True)
class Saddle:
    """All contacts at given parameters.

    N; N^T - c_f T^T; abs(N^T) + abs(c_f T^T); c_c of each force; coordinates of forces of right and
    of left vectors; norm of what these leave out.
    """

    closes: Floats
    reacts: Floats
    sizes: Floats
    compliance: Floats
    right: Floats
    left: Floats
    lost: float

    @classmethod
    def at(cls, contacts: Sequence[SmallContact], values: Values) -> "Saddle | None":
        """Contacts at values of all parameters; None where there is none."""
        if not contacts:
            return None
        factors = [each.friction.at(values) for each in contacts]
        both = list(zip(factors, contacts, strict=True))
        return cls(
            np.vstack([each.closes for each in contacts]),
            np.hstack([(each.closes - c * each.slides).T for c, each in both]),
            np.hstack([(np.abs(each.closes) + abs(c) * np.abs(each.slides)).T for c, each in both]),
            np.concatenate(
                [np.full(len(e.closes), e.inverse_stiffness.at(values)) for e in contacts]
            ),
            np.hstack([each.normal_forces - c * each.friction_forces for c, each in both]),
            np.hstack([each.normal_forces for each in contacts]),
            sum((1 + abs(c)) * each.lost for c, each in both),
        )

    def with_stiffness(self, stiffness: Residuals) -> Residuals:
        """K with the contacts, for vectors of displacements and forces one below the other."""
        square = np.block(
            [[stiffness.square, self.reacts], [self.closes, -np.diag(self.compliance)]]
        )
        return replace(
            stiffness,
            square=square,
            right=np.hstack([stiffness.right, self.right]),
            left=np.hstack([stiffness.left, self.left]),
            lost=stiffness.lost + self.lost,
        )

    def beside(self, matrix: Residuals) -> Residuals:
        """M or D, which forces have no part in."""
        wider = ((0, 0), (0, len(self.compliance)))
        right = np.pad(matrix.right, wider)
        left = right if matrix.left is matrix.right else np.pad(matrix.left, wider)
        return replace(matrix, square=self.padded(matrix.square), right=right, left=left)

    def padded(self, square: Floats) -> Floats:
        """A square matrix with zeros for the forces."""
        return block_diag(square, np.zeros((len(self.compliance),) * 2))

    def rounded(self, entries: Floats) -> Floats:
        """Sizes of parts of K with those of the contacts."""
        return np.block([[entries, self.sizes], [np.abs(self.closes), np.diag(self.compliance)]])


class Inverse:
    """The inverse of a shifted stiffness, shape (k, k), with contacts where there are any."""

    def __init__(self, shifted: Floats, saddle: Saddle | None) -> None:
        self._factors, self._saddle = lu_factor(shifted), saddle
        if saddle is not None:
            self._flexible = lu_solve(self._factors, saddle.reacts)
            whole = np.diag(saddle.compliance) + saddle.closes @ self._flexible
            self._schur = lu_factor(whole)

    def __call__(self, block: Floats) -> Floats:
        """Displacements under a block of forces."""
        found: Floats = lu_solve(self._factors, block)
        if self._saddle is not None:
            found -= self._flexible @ lu_solve(self._schur, self._saddle.closes @ found)
        return found

    def extended[T: NDArray[np.inexact]](self, vectors: T, loads: T) -> T:
        """Right vectors with their contact forces below, by the loads they are in balance with."""
        if self._saddle is None:
            return vectors
        forces = lu_solve(self._schur, self._saddle.closes @ lu_solve(self._factors, loads))
        return np.vstack([vectors, forces])  # type: ignore[return-value]

    def extended_left[T: NDArray[np.inexact]](self, vectors: T, loads: T) -> T:
        """The same of left vectors."""
        if self._saddle is None:
            return vectors
        moved = lu_solve(self._factors, loads, trans=1)
        forces = lu_solve(self._schur, self._saddle.reacts.T @ moved, trans=1)
        return np.vstack([vectors, forces])  # type: ignore[return-value]
