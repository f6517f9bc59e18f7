"""Factorised matrices: all that a driver needs of MUMPS, set up in one place."""

from typing import Any, Protocol

import numpy as np

from cea.body import Floats
from cea.errors import ConvergenceError
from cea.matrices import destroy
from cea.petsc import PETSc


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


class Mumps:
    """LU, or LDL^T of a symmetric matrix, by MUMPS.

    Parameters
    ----------
    matrix
        A, PETSc AIJ; it is destroyed with the factors.
    symmetric
        Whether A is symmetric.
    inertia
        Whether its negative eigenvalues will be asked for; null pivots are then counted rather
        than failed on, and systems should not be solved.

    Raises
    ------
    ConvergenceError
        When A is singular, or the factorisation fails.
    """

    def __init__(self, matrix: Any, *, symmetric: bool, inertia: bool = False) -> None:
        self.matrix = matrix
        if symmetric:
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self._pc = PETSc.PC().create(matrix.comm)
        self._pc.setOperators(matrix)
        self._pc.setType(PETSc.PC.Type.CHOLESKY if symmetric else PETSc.PC.Type.LU)
        self._pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        if inertia:
            self._pc.setFactorSetUpSolverType()
            factor = self._pc.getFactorMatrix()
            factor.setMumpsIcntl(13, 1)  # a parallel root hides its inertia
            factor.setMumpsIcntl(24, 1)
        self._pc.setUp()
        if self._pc.getFailedReason() != PETSc.PC.FailedReason.NOERROR:
            self.free()
            raise ConvergenceError(f"a matrix of {matrix_size(matrix)} rows is singular")

    def solve(self, b: Any, x: Any, *, transposed: bool = False) -> None:
        """Solve A x = b, or A^T x = b, with PETSc vectors."""
        if transposed:
            self._pc.applyTranspose(b, x)
        else:
            self._pc.apply(b, x)

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """Solve for every column of b: the rows of this rank, shape (n_local, columns)."""
        if transposed:
            return _column_by_column(self, b)
        size = (self.matrix.getSizes()[0], (PETSc.DECIDE, b.shape[1]))
        right = PETSc.Mat().createDense(size, array=np.asfortranarray(b), comm=self.matrix.comm)
        left = PETSc.Mat().createDense(size, comm=self.matrix.comm).setUp()
        self._pc.matApply(right, left)
        solution = left.getDenseArray().copy()
        destroy(right, left)
        return solution

    def steps(self) -> int:
        """One: the factors are its own."""
        return 1

    def negative_eigenvalues(self) -> int:
        """Number of negative eigenvalues of a symmetric A, by its inertia."""
        negative, _, _ = self._pc.getFactorMatrix().getInertia()
        return int(negative)

    def free(self) -> None:
        """Free the factors and the matrix."""
        destroy(self._pc, self.matrix)


class Refined:
    """A matrix solved by the factors of a nearby one and a few steps of GMRES.

    Parameters
    ----------
    matrix
        A, PETSc AIJ; it is destroyed with this object, the factors are not.
    near
        Factors of a matrix near A.
    most_steps
        Steps beyond which A is not near.

    Raises
    ------
    ConvergenceError
        When a system takes more steps.
    """

    _TOLERANCE = 1e-14

    def __init__(self, matrix: Any, near: Factorisation, most_steps: int = 8) -> None:
        self.matrix = matrix
        self._solver = PETSc.KSP().create(matrix.comm)
        self._solver.setOperators(matrix)
        self._solver.setType(PETSc.KSP.Type.GMRES)
        self._solver.setPCSide(PETSc.PC.Side.RIGHT)
        self._solver.setTolerances(rtol=self._TOLERANCE, atol=0.0, max_it=most_steps)
        pc = self._solver.getPC()
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(Applied(near))
        self._solver.setUp()

    def solve(self, b: Any, x: Any, *, transposed: bool = False) -> None:
        """Solve A x = b, or A^T x = b, with PETSc vectors."""
        (self._solver.solveTranspose if transposed else self._solver.solve)(b, x)
        if self._solver.getConvergedReason() < 0:
            raise ConvergenceError("the factors are not of a nearby matrix", best=x)

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """Solve for every column of b: the rows of this rank, shape (n_local, columns)."""
        return _column_by_column(self, b, transposed=transposed)

    def steps(self) -> int:
        """Steps that a system of random numbers takes, one more than allowed where it is lost."""
        x, b = self.matrix.createVecs()
        b.setRandom()
        self._solver.solve(b, x)
        taken, lost = self._solver.getIterationNumber(), self._solver.getConvergedReason() < 0
        destroy(x, b)
        return int(taken) + int(lost)

    def free(self) -> None:
        """Free all but the factors."""
        destroy(self._solver, self.matrix)


class Applied:
    """A factorisation as the context of a PETSc preconditioner.

    Parameters
    ----------
    factors
        What solves.
    transposed
        Whether the transposed matrix is what PETSc knows.
    """

    def __init__(self, factors: Factorisation, *, transposed: bool = False) -> None:
        self._factors = factors
        self._transposed = transposed

    def apply(self, _: Any, b: Any, x: Any) -> None:
        """Solve with the matrix."""
        self._factors.solve(b, x, transposed=self._transposed)

    def applyTranspose(self, _: Any, b: Any, x: Any) -> None:
        """Solve with the transposed matrix."""
        self._factors.solve(b, x, transposed=not self._transposed)


def matrix_size(matrix: Any) -> int:
    """Number of rows over all ranks."""
    return int(matrix.getSize()[0])


def _column_by_column(factors: Any, b: Floats, *, transposed: bool = True) -> Floats:
    x, right = factors.matrix.createVecs()
    columns = np.empty_like(b)
    for i, column in enumerate(b.T):
        right.array[:] = column
        factors.solve(right, x, transposed=transposed)
        columns[:, i] = x.array_r
    destroy(x, right)
    return columns
