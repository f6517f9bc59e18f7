"""A pencil factorised at a shift: displacements, and contact forces where they are unknowns.

With forces f as unknowns (:mod:`cea.eigen.multipliers`) the matrix at kappa = -lambda^2 is

    A(kappa) = [ K - kappa M   L^T     ]
               [      J        -C   Z  ]
               [               Z^T     ]

and the displacement part of A(kappa)^-1 [r; 0] is what drivers iterate with: multipliers carry no
mass, and Krylov spaces stay ones of displacements. Pieces of C of low rank stay out of the factors,
and so do circulatory pieces of K of damped problems where they are small
(:mod:`cea.eigen.updated_factors`); otherwise they are unknowns beside the forces.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.eigen.multipliers import Multipliers, with_circulatory
from cea.eigen.mumps import Mumps, SingularError
from cea.eigen.pencil import Matrices
from cea.eigen.unformed import CirculatorySum
from cea.eigen.updated_factors import UpdatedFactors
from cea.matrices import destroy
from cea.petsc import PETSc


class Shifted:
    """A(kappa) + s (C + Y) factorised at a shift kappa (1/s^2) and a rate s (1/s); SingularError.

    With kappa = -s^2 it is that of a quadratic problem; :meth:`quadratic`.
    """

    def __init__(self, matrices: Matrices, kappa: float = 0.0, rate: float = 0.0) -> None:
        self.matrices, self.kappa, self.rate = matrices, kappa, rate
        self._local = matrices.stiffness.getLocalSize()[0]
        turns = bool(rate) and matrices.gyroscopic is not None
        self._symmetric = matrices.symmetric and not turns
        self._forces, circulatory = matrices.multipliers, matrices.circulatory
        if rate and circulatory is not None:
            try:
                self._factorise(circulatory)
            except SingularError:
                self.free()
            else:
                return
        if circulatory is not None:
            self._forces = with_circulatory(matrices.multipliers, circulatory)
        self._factorise(None)

    @classmethod
    def quadratic(cls, matrices: Matrices, rate: float) -> "Shifted":
        """P(s) = s^2 M + s (C + Y) + K factorised at a real s (1/s)."""
        return cls(matrices, -(rate**2), rate)

    def _factorise(self, rest: CirculatorySum | None) -> None:
        """Factors with the forces, and what solves with pieces that stay out of them."""
        operator = self.matrices.operator(self.kappa, rate=self.rate)
        if self._forces is not None:
            whole = bordered(operator, self._forces, symmetric=self._symmetric)
            destroy(operator)
            operator = whole
        self._update: UpdatedFactors | None = None
        self._factors: Mumps | None = None
        self._factors = Mumps(operator, symmetric=self._symmetric)
        low_rank = self.matrices.low_rank if self.rate else None
        if low_rank is None and rest is None:
            return
        root = np.zeros((self._local, 0)) if low_rank is None else low_rank.vectors
        try:
            self._update = UpdatedFactors(
                self._factors, root, self.rate, rest, symmetric=self._symmetric
            )
        except SingularError:
            self.free()
            raise

    @property
    def multipliers(self) -> int:
        """Number of contact forces on this rank that are unknowns."""
        forces = self.matrices.multipliers
        return 0 if forces is None else int(forces.compliance.getLocalSize()[0])

    def solve_block(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Displacements for every column of forces, the rows of this rank."""
        return self.solve_with_forces(b, transposed=transposed)[0]

    def solve_with_forces(
        self, b: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Displacements and contact forces for every column of forces, the rows of this rank.

        They are real or complex; the matrix may be the transposed one.
        """
        solver = self._update or self._factors
        assert solver is not None
        solution = solver.solve_block(b, transposed=transposed)
        return solution[: self._local], solution[self._local : self._local + self.multipliers]

    def parity(self) -> int | None:
        """Whether the number of real eigenvalues beyond the shift is odd (1) or even (0).

        Those are kappa below it, or lambda above it. The determinant has the sign of (-1)^m there,
        m contact forces, far away, and changes it at each real eigenvalue. None where it is not
        known: for symmetric matrices and forces without compliance.
        """
        if self._symmetric or (self._forces is not None and self._forces.tied):
            return None
        assert self._factors is not None
        sign = self._factors.sign() * (1 if self._update is None else self._update.sign())
        return int(sign != (-1) ** (0 if self._forces is None else self._forces.size))

    def free(self) -> None:
        """Free the factors."""
        if self._factors is not None:
            self._factors.free()
        self._factors = self._update = None
        if self._forces is not None and self._forces is not self.matrices.multipliers:
            self._forces.free()


def count_below(matrices: Matrices, kappa: float) -> int:
    """Number of eigenvalues of the symmetric part below kappa (1/s^2), by its inertia.

    Each multiplier adds one negative eigenvalue to those of S - kappa M; so it does beside a row
    of Z^T, which takes one of its own sign and one of the other.
    """
    shifted = matrices.operator(kappa, symmetric_part=True)
    extra = 0
    if matrices.multipliers is not None:
        whole = bordered(shifted, matrices.multipliers, symmetric=True)
        destroy(shifted)
        shifted, extra = whole, matrices.multipliers.size
    factors = Mumps(shifted, symmetric=True, inertia=True)
    negative = factors.negative_eigenvalues()
    factors.free()
    return negative - extra


def bordered(operator: Any, multipliers: Multipliers, *, symmetric: bool) -> Any:
    """[A, L^T, .; J, -C, Z; ., Z^T, .], PETSc AIJ, which MUMPS scales; L is J where symmetric."""
    closure = multipliers.closure
    reaction = closure if symmetric else multipliers.reaction
    transpose, corner = reaction.transpose(PETSc.Mat()), multipliers.compliance.copy()
    corner.scale(-1.0)
    blocks, made = [[operator, transpose], [closure, corner]], [transpose, corner]
    if (border := multipliers.border) is not None:
        across = border.transpose(PETSc.Mat())
        blocks = [[operator, transpose, None], [closure, corner, border], [None, across, None]]
        made.append(across)
    whole = PETSc.Mat().createNest(blocks).convert("aij")
    destroy(*made)
    return whole
