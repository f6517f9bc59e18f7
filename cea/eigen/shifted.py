"""A pencil factorised at a shift: displacements, and contact forces where they are unknowns.

With forces f as unknowns (:mod:`cea.eigen.multipliers`) the matrix at kappa = -lambda^2 is

    A(kappa) = [ K - kappa M   L^T     ]
               [      J        -C   Z  ]
               [               Z^T     ]

and the driver iterates with the displacement part of A(kappa)^-1 [r; 0]: multipliers carry no mass,
so Krylov vectors hold displacements alone. Circulatory terms of K and low-rank terms of C would
fill the matrix; their unknowns are appended to the forces instead.
"""

from typing import Any

from numpy.typing import NDArray

from cea.eigen.multipliers import Multipliers, with_unformed
from cea.eigen.mumps import Mumps, inertia
from cea.eigen.pencil import Matrices
from cea.matrices import destroy
from cea.petsc import PETSc


class Shifted:
    """Factors of A(kappa) + s (C + Y) at a shift kappa (1/s^2) and a rate s (1/s).

    SingularError when the matrix is singular. See :meth:`quadratic` for kappa = -s^2.
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
        """Factorise P(s) = s^2 M + s (C + Y) + K at a real s (1/s)."""
        return cls(matrices, -(rate**2), rate)

    @property
    def multipliers(self) -> int:
        """Number of multipliers on this rank."""
        forces = self.matrices.multipliers
        return 0 if forces is None else int(forces.compliance.getLocalSize()[0])

    def solve_block(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Return displacements for every column of forces, the rows of this rank."""
        return self.solve_with_forces(b, transposed=transposed)[0]

    def solve_with_forces(
        self, b: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return displacements and multipliers for every column of forces, the rows of this rank.

        Forces are real or complex; the system may be transposed.
        """
        solution = self._factors.solve_block(b, transposed=transposed)
        return solution[: self._local], solution[self._local : self._local + self.multipliers]

    def parity(self) -> int | None:
        """Return the parity of the number of real eigenvalues beyond the shift: 1 if it is odd.

        Beyond means kappa below the shift, or lambda above it. Far away in that direction the
        determinant has the sign (-1)^m with m contact forces, and changes it at each real
        eigenvalue. None for symmetric matrices and forces without compliance, where it is unknown.
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
    """Return the number of eigenvalues of the symmetric part below kappa (1/s^2), by inertia.

    Each multiplier adds one negative eigenvalue to those of S - kappa M, also where there are rows
    Z^T: each of these adds one positive eigenvalue.
    """
    forces, shifted = matrices.contacts, matrices.operator(kappa, symmetric_part=True)
    negative, _ = inertia(bordered(shifted, forces, symmetric=True))
    return negative - (0 if forces is None else forces.size)


def bordered(operator: Any, multipliers: Multipliers | None, *, symmetric: bool) -> Any:
    """Return [A, L^T, .; J, -C, Z; ., Z^T, .] as PETSc AIJ; A is destroyed.

    L is J where symmetric. Returns A itself without multipliers. MUMPS scales the matrix.
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
