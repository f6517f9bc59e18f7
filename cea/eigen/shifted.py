"""A pencil factorised at a shift: displacements, and contact forces where they are unknowns.

With forces f as unknowns (:mod:`cea.eigen.multipliers`) the matrix at kappa = -lambda^2 is

    A(kappa) = [ K - kappa M   L^T     ]
               [      J        -C   Z  ]
               [               Z^T     ]

and the displacement part of A(kappa)^-1 [r; 0] is what drivers iterate with: multipliers carry no
mass, and Krylov spaces stay ones of displacements. Circulatory pieces of K, and those of C of low
rank, would fill the matrix: they are unknowns beside the forces.
"""

from typing import Any

from numpy.typing import NDArray

from cea.eigen.multipliers import Multipliers, with_unformed
from cea.eigen.mumps import Mumps, inertia
from cea.eigen.pencil import Matrices
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
        self._symmetric = symmetric = matrices.symmetric and not turns
        unknowns = []
        if rate and matrices.low_rank is not None:
            unknowns.append(matrices.low_rank.unknowns(rate, matrices.mass.comm))
        self._forces = with_unformed(matrices.multipliers, unknowns)
        whole = bordered(matrices.operator(kappa, rate=rate), self._forces, symmetric=symmetric)
        self._factors = Mumps(whole, symmetric=symmetric)

    @classmethod
    def quadratic(cls, matrices: Matrices, rate: float) -> "Shifted":
        """P(s) = s^2 M + s (C + Y) + K factorised at a real s (1/s)."""
        return cls(matrices, -(rate**2), rate)

    @property
    def multipliers(self) -> int:
        """Number of multipliers on this rank."""
        forces = self.matrices.multipliers
        return 0 if forces is None else int(forces.compliance.getLocalSize()[0])

    def solve_block(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Displacements for every column of forces, the rows of this rank."""
        return self.solve_with_forces(b, transposed=transposed)[0]

    def solve_with_forces(
        self, b: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Displacements and multipliers for every column of forces, the rows of this rank.

        They are real or complex; the matrix may be the transposed one.
        """
        solution = self._factors.solve_block(b, transposed=transposed)
        return solution[: self._local], solution[self._local : self._local + self.multipliers]

    def parity(self) -> int | None:
        """Whether the number of real eigenvalues beyond the shift is odd (1) or even (0).

        Those are kappa below it, or lambda above it. The determinant has the sign of (-1)^m there,
        m contact forces, far away, and changes it at each real eigenvalue. None where it is not
        known: for symmetric matrices and forces without compliance.
        """
        if self._symmetric or (self._forces is not None and self._forces.tied):
            return None
        forces = 0 if self._forces is None else self._forces.size
        return int(self._factors.sign() != (-1) ** forces)

    def free(self) -> None:
        """Free the factors."""
        self._factors.free()
        if self._forces is not None and self._forces is not self.matrices.multipliers:
            self._forces.free()


def count_below(matrices: Matrices, kappa: float) -> int:
    """Number of eigenvalues of the symmetric part below kappa (1/s^2), by its inertia.

    Each multiplier adds one negative eigenvalue to those of S - kappa M; so it does beside a row
    of Z^T, which takes one of its own sign and one of the other.
    """
    forces, shifted = matrices.contacts, matrices.operator(kappa, symmetric_part=True)
    negative, _ = inertia(bordered(shifted, forces, symmetric=True))
    return negative - (0 if forces is None else forces.size)


def bordered(operator: Any, multipliers: Multipliers | None, *, symmetric: bool) -> Any:
    """[A, L^T, .; J, -C, Z; ., Z^T, .], PETSc AIJ, in the place of A, which is destroyed.

    MUMPS scales it; L is J where symmetric. A itself without multipliers.
    """
    if multipliers is None:
        return operator
    closure = multipliers.closure
    reaction = closure if symmetric else multipliers.reaction
    transpose, corner = reaction.transpose(PETSc.Mat()), multipliers.compliance.copy()
    corner.scale(-1.0)
    blocks, made = [[operator, transpose], [closure, corner]], [operator, transpose, corner]
    if (border := multipliers.border) is not None:
        across = border.transpose(PETSc.Mat())
        blocks = [[operator, transpose, None], [closure, corner, border], [None, across, None]]
        made.append(across)
    whole = PETSc.Mat().createNest(blocks).convert("aij")
    destroy(*made)
    return whole
