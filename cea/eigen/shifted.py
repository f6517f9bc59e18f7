"""A pencil factorised at a shift: displacements, and contact forces where they are unknowns.

With forces f as unknowns (:mod:`cea.eigen.multipliers`) the matrix at kappa = -lambda^2 is

    A(kappa) = [ K - kappa M   L^T ]
               [      J        -C  ]

and the displacement part of A(kappa)^-1 [r; 0] is what drivers iterate with: multipliers carry no
mass, and Krylov spaces stay ones of displacements.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from cea.body import Floats
from cea.eigen.factorisation import Mumps, Refined
from cea.eigen.multipliers import Multipliers
from cea.eigen.pencil import Matrices
from cea.matrices import destroy
from cea.petsc import MPI, PETSc


class Shifted:
    """A(kappa) factorised; what a driver solves for displacements with.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    kappa
        The shift (1/s^2).
    near
        Nearby factors to be refined, instead of factors of its own.

    Raises
    ------
    ConvergenceError
        When A(kappa) is singular.
    """

    def __init__(
        self, matrices: Matrices, kappa: float = 0.0, *, near: "Shifted | None" = None
    ) -> None:
        self.kappa = kappa
        self._matrices = matrices
        self._multipliers = matrices.multipliers
        self._local = matrices.stiffness.getLocalSize()[0]
        self._scale = 1.0
        operator = self._operator(near)
        self._factors: Mumps | Refined = (
            Refined(operator, near._factors)
            if near
            else Mumps(operator, symmetric=matrices.symmetric)
        )
        self._x: Any | None = None
        self._b: Any | None = None
        if self._multipliers is not None:
            self._x, self._b = operator.createVecRight(), operator.createVecLeft()

    def _operator(self, near: "Shifted | None" = None) -> Any:
        """A(kappa), with the contact forces."""
        operator = self._matrices.operator(self.kappa)
        if self._multipliers is None:
            return operator
        self._scale = near._scale if near else force_scale(operator, self._multipliers)
        whole = _bordered(
            operator, self._multipliers, self._scale, symmetric=self._matrices.symmetric
        )
        destroy(operator)
        return whole

    def move(self, kappa: float) -> None:
        """Factorise at another shift instead.

        Raises
        ------
        ConvergenceError
            When A(kappa) is singular.
        """
        if kappa == self.kappa:
            return
        assert isinstance(self._factors, Mumps)
        before, self.kappa = self.kappa, kappa
        if self._multipliers is None:
            subset = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN
            self._factors.matrix.axpy(before - kappa, self._matrices.mass, structure=subset)
            self._factors.factorise()
            return
        self._factors.free()
        self._factors = Mumps(self._operator(), symmetric=self._matrices.symmetric)

    def solve(self, b: Any, x: Any, *, transposed: bool = False) -> None:
        """Displacements x for forces b on the bodies, PETSc vectors."""
        if self._x is None or self._b is None:
            self._factors.solve(b, x, transposed=transposed)
            return
        self._b.set(0.0)
        self._b.array[: self._local] = b.array_r
        self._factors.solve(self._b, self._x, transposed=transposed)
        x.array[:] = self._x.array_r[: self._local]

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """Displacements for every column of forces, the rows of this rank."""
        return self.solve_with_forces(b, transposed=transposed)[0]

    def solve_with_forces(self, b: Floats, *, transposed: bool = False) -> tuple[Floats, Floats]:
        """Displacements and contact forces for every column of forces, the rows of this rank.

        Returns
        -------
        tuple
            Shapes (n_local, columns) and (multipliers of this rank, columns).
        """
        whole = b
        if self._b is not None:
            whole = np.zeros((self._b.getLocalSize(), b.shape[1]), order="F")
            whole[: self._local] = b
        solution = self._factors.solve_block(whole, transposed=transposed)
        return solution[: self._local], solution[self._local :] * self._scale

    def parity(self) -> int | None:
        """Whether the number of real eigenvalues kappa below the shift is odd (1) or even (0).

        The determinant of A(kappa) has the sign of (-1)^m, m contact forces, far to the left, and
        changes it at each real eigenvalue. None where that is not known: for a symmetric pencil,
        refined factors, forces without compliance.
        """
        if self._matrices.symmetric or isinstance(self._factors, Refined):
            return None
        forces = 0
        if self._multipliers is not None:
            tied = bool((self._multipliers.compliance.array_r == 0).any())
            if self._matrices.stiffness.comm.tompi4py().allreduce(tied, MPI.LOR):
                return None
            forces = self._multipliers.size
        return int(self._factors.sign() != (-1) ** forces)

    def steps(self) -> int:
        """Steps that a system takes: 1 with factors of its own."""
        return self._factors.steps()

    def free(self) -> None:
        """Free the factors."""
        self._factors.free()
        destroy(*(v for v in (self._x, self._b) if v is not None))


def count_below(matrices: Matrices, kappa: float) -> int:
    """Number of eigenvalues of the symmetric part below kappa (1/s^2), by its inertia.

    Each multiplier adds one negative eigenvalue to those of S - kappa M.

    Raises
    ------
    ConvergenceError
        When the factorisation fails.
    """
    shifted = matrices.operator(kappa, symmetric_part=True)
    extra = 0
    if matrices.multipliers is not None:
        symmetric = replace(matrices.multipliers, reaction=matrices.multipliers.closure)
        scale = force_scale(shifted, symmetric)
        bordered = _bordered(shifted, symmetric, scale, symmetric=True)
        destroy(shifted)
        shifted, extra = bordered, symmetric.size
    factors = Mumps(shifted, symmetric=True, inertia=True)
    negative = factors.negative_eigenvalues()
    factors.free()
    return negative - extra


def force_scale(operator: Any, multipliers: Multipliers) -> float:
    """Factor on multipliers that makes rows of J as large as those of the bodies."""
    closure: Any = multipliers.closure
    diagonal = operator.getDiagonal()
    largest = diagonal.norm(PETSc.NormType.INFINITY)
    destroy(diagonal)
    rows = closure.norm(PETSc.NormType.INFINITY)
    return float(largest / rows) if largest > 0 and rows > 0 else 1.0


def _bordered(operator: Any, multipliers: Multipliers, scale: float, *, symmetric: bool) -> Any:
    """[A, s L^T; s J, -s^2 C] as PETSc AIJ; with J for L in its symmetric part."""
    closure = multipliers.closure.copy()
    closure.scale(scale)
    reaction = closure
    if not symmetric:
        reaction = multipliers.reaction.copy()
        reaction.scale(scale)
    transpose = reaction.transpose(PETSc.Mat())
    diagonal = multipliers.compliance.copy()
    diagonal.scale(-(scale**2))
    rows = (multipliers.compliance.getLocalSize(), multipliers.size)
    corner = PETSc.Mat().createAIJ(size=(rows, rows), nnz=1, comm=operator.comm)
    corner.setUp()
    corner.setDiagonal(diagonal)
    corner.assemble()
    bordered = PETSc.Mat().createNest([[operator, transpose], [closure, corner]]).convert("aij")
    destroy(transpose, diagonal, corner, closure)
    if reaction is not closure:
        destroy(reaction)
    return bordered
