"""The pencil S - F - kappa M of a system, with contact forces eliminated or as unknowns.

With forces f as unknowns (:mod:`cea.contact.saddle`) the operator is

    A(kappa) = [ S - F - kappa M   L^T ]
               [        J          -C  ]

and the displacement part of A(kappa)^-1 [r; 0] is what the driver iterates with: multipliers carry
no mass, and the Krylov space stays one of displacements.
"""

from typing import Any

import numpy as np

from cea.body import Floats
from cea.contact.saddle import Multipliers
from cea.errors import ConvergenceError
from cea.matrices import destroy
from cea.petsc import PETSc

_DIFFERENT = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN


class Pencil:
    """Symmetric S and M, unsymmetric F, and multipliers.

    Parameters
    ----------
    stiffness
        Symmetric part S, PETSc AIJ (N/m).
    mass
        Symmetric positive definite M, PETSc AIJ (kg); None in statics.
    friction
        Unsymmetric part F, PETSc AIJ (N/m); None without.
    multipliers
        Contact forces that are unknowns; None without.
    """

    def __init__(
        self,
        stiffness: Any,
        mass: Any | None,
        friction: Any | None = None,
        multipliers: Multipliers | None = None,
    ) -> None:
        self.stiffness = stiffness
        self.mass = mass
        self.friction = friction
        self.multipliers = multipliers

    @property
    def symmetric(self) -> bool:
        """True without friction."""
        return self.friction is None and (self.multipliers is None or self.multipliers.symmetric)

    def displacement_operator(self) -> Any:
        """S - F: S itself without friction, else a new PETSc AIJ matrix."""
        if self.friction is None:
            return self.stiffness
        operator = self.stiffness.copy()
        operator.axpy(-1.0, self.friction, structure=_DIFFERENT)
        return operator

    def count_below(self, kappa: float) -> int:
        """Number of eigenvalues of the symmetric part below kappa, by its inertia.

        Each multiplier adds one negative eigenvalue to those of S - kappa M.

        Parameters
        ----------
        kappa
            Upper end (1/s^2).

        Raises
        ------
        ConvergenceError
            When the factorisation fails.
        """
        shifted = self.stiffness.copy()
        shifted.axpy(-kappa, self.mass, structure=_DIFFERENT)
        extra = 0
        if self.multipliers is not None:
            bordered = _bordered(shifted, self.multipliers, symmetric=True)
            destroy(shifted)
            shifted, extra = bordered, self.multipliers.size
        shifted.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        pc = PETSc.PC().create(shifted.comm)
        pc.setOperators(shifted)
        pc.setType(PETSc.PC.Type.CHOLESKY)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        pc.setFactorSetUpSolverType()
        factor = pc.getFactorMatrix()
        factor.setMumpsIcntl(13, 1)  # a parallel root hides its inertia
        factor.setMumpsIcntl(24, 1)  # null pivots are counted, not failed on
        pc.setUp()
        if pc.getFailedReason() != PETSc.PC.FailedReason.NOERROR:
            raise ConvergenceError(f"S - kappa M could not be factorised at kappa = {kappa:.6g}")
        negative, _, _ = factor.getInertia()
        destroy(pc, shifted)
        return int(negative) - extra

    def bordered(self, kappa: float = 0.0) -> "BorderedSolver":
        """Factorised A(kappa); only with multipliers."""
        return BorderedSolver(self, kappa)


class BorderedSolver:
    """Displacements and contact forces for given forces on the bodies: A(kappa)^-1 [r; 0].

    As the context of a PETSc preconditioner it returns the displacements alone.
    """

    def __init__(self, pencil: Pencil, kappa: float) -> None:
        assert pencil.multipliers is not None
        operator = pencil.displacement_operator()
        if operator is pencil.stiffness:
            operator = operator.copy()
        if kappa:
            operator.axpy(-kappa, pencil.mass, structure=_DIFFERENT)
        self.multipliers = pencil.multipliers
        self._scale = _scale(operator, pencil.multipliers)
        self._matrix = _bordered(operator, pencil.multipliers, symmetric=pencil.symmetric)
        destroy(operator)
        self._solver = PETSc.KSP().create(self._matrix.comm)
        self._solver.setOperators(self._matrix)
        self._solver.setType(PETSc.KSP.Type.PREONLY)
        pc = self._solver.getPC()
        pc.setType(PETSc.PC.Type.CHOLESKY if pencil.symmetric else PETSc.PC.Type.LU)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        self._solver.setUp()
        self._right, self._left = self._matrix.createVecs()
        self._size = pencil.stiffness.getLocalSize()[0]

    def solve(self, force: Any, displacement: Any, contact: Any | None = None) -> bool:
        """Solve for displacements x and, if asked for, contact forces f; False when singular."""
        self._left.set(0.0)
        self._left.array[: self._size] = force.array_r
        self._solver.solve(self._left, self._right)
        displacement.array[:] = self._right.array_r[: self._size]
        if contact is not None:
            contact.array[:] = self._right.array_r[self._size :] * self._scale
        return bool(self._solver.getConvergedReason() >= 0)

    def apply(self, _: Any, x: Any, y: Any) -> None:
        """Displacements y for forces x: the context of a PETSc preconditioner."""
        self.solve(x, y)

    def solve_block(self, forces: Floats) -> tuple[Floats, Floats]:
        """Displacements and contact forces for each column of forces, the rows of this rank."""
        local, n = self._matrix.getLocalSize()[0], forces.shape[1]
        extended = np.zeros((local, n), order="F")
        extended[: self._size] = forces
        size = (self._matrix.getSizes()[0], (PETSc.DECIDE, n))
        right = PETSc.Mat().createDense(size, array=extended, comm=self._matrix.comm)
        left = PETSc.Mat().createDense(size, comm=self._matrix.comm).setUp()
        self._solver.matSolve(right, left)
        solution = left.getDenseArray().copy()
        destroy(right, left)
        return solution[: self._size], solution[self._size :] * self._scale

    def free(self) -> None:
        """Free the factorisation."""
        destroy(self._solver, self._matrix, self._right, self._left)


def _scale(operator: Any, multipliers: Multipliers) -> float:
    """Factor on multipliers that makes rows of J as large as those of the bodies."""
    diagonal = operator.getDiagonal()
    largest = diagonal.norm(PETSc.NormType.INFINITY)
    destroy(diagonal)
    rows = multipliers.closure.norm(PETSc.NormType.INFINITY)
    return float(largest / rows) if largest > 0 and rows > 0 else 1.0


def _bordered(operator: Any, multipliers: Multipliers, *, symmetric: bool) -> Any:
    """[A, s L^T; s J, -s^2 C] as PETSc AIJ; with J for L in its symmetric part."""
    scale = _scale(operator, multipliers)
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
    if symmetric:
        bordered.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    destroy(transpose, diagonal, corner, closure)
    if reaction is not closure:
        destroy(reaction)
    return bordered
