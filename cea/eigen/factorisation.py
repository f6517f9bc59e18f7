"""Factorised matrices: all that a driver needs of MUMPS, set up in one place."""

import sys
from typing import Any, Protocol

import numpy as np

from cea.arrays import Floats
from cea.eigen.factors_on_disk import folder_of_factors
from cea.errors import ConvergenceError
from cea.matrices import dense, destroy
from cea.petsc import PETSc

_SOLVED = 1e-11
"""Relative defect up to which a refined system counts as solved."""

_ROOM = (20, 200, 1000)
"""Room (per cent) for pivots that are delayed beyond what is foreseen: more where it runs out."""
_NO_ROOM: Any = PETSc.PC.FailedReason.FACTOR_OUTMEMORY
_LARGE = 10_000
"""Unknowns from which on inertia is found by an order of nodes, and in panels."""
_SAME = 0.9
"""Part of the nodes of which all unknowns have equally many entries, where unknowns are by node."""


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
        than failed on, and with any of them systems should not be solved.
    single
        Whether in single precision, at half the time and memory; in double where that fails.

    Attributes
    ----------
    single
        Whether the factors are of single precision.

    Raises
    ------
    ConvergenceError
        When A is singular, or the factorisation fails.
    """

    def __init__(
        self, matrix: Any, *, symmetric: bool, inertia: bool = False, single: bool = False
    ) -> None:
        self.matrix = matrix
        self.single = single
        self._symmetric, self._inertia = symmetric, inertia
        if symmetric:
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self._pc = self._prepared(_ROOM[0])
        self.factorise()

    def in_double(self) -> None:
        """Factorise once more, in double precision.

        Raises
        ------
        ConvergenceError
            When A is singular, or the factorisation fails.
        """
        self.single = False
        destroy(self._pc)
        self._pc = self._prepared(_ROOM[0])
        self.factorise()

    def factorise(self) -> None:
        """Factorise the matrix, once more where its entries have changed: its order is kept."""
        self._pc.setOperators(self.matrix)
        self._set_up()
        for room in _ROOM[1:]:
            if self._pc.getFailedReason() != _NO_ROOM:
                break
            destroy(self._pc)
            self._pc = self._prepared(room)
            self._set_up()
        if self._pc.getFailedReason() != PETSc.PC.FailedReason.NOERROR:
            if self.single:
                self.in_double()
                return
            rows = matrix_size(self.matrix)
            self.free()
            raise ConvergenceError(f"a matrix of {rows} rows is singular")

    def _set_up(self) -> None:
        """Factorise; PETSc reads precision and folder from its options, and only then."""
        options: Any = PETSc.Options()
        given = {"pc_precision": "single"} if self.single else {}
        if (folder := folder_of_factors()) is not None:
            given["mat_mumps_ooc_tmpdir"] = str(folder)
        for name, value in given.items():
            options.setValue(name, value)
        try:
            self._pc.setUp()
        finally:
            for name in given:
                options.delValue(name)

    def _prepared(self, room: int) -> Any:
        """PETSc preconditioner, set up but for the factors."""
        pc: Any = PETSc.PC().create(self.matrix.comm)
        pc.setOperators(self.matrix)
        pc.setType(PETSc.PC.Type.CHOLESKY if self._symmetric else PETSc.PC.Type.LU)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        pc.setFactorSetUpSolverType()
        factor = pc.getFactorMatrix()
        factor.setMumpsIcntl(14, room)
        factor.setMumpsIcntl(22, int(folder_of_factors() is not None))
        if self._inertia:
            factor.setMumpsIcntl(13, 1)  # a parallel root hides its inertia
            factor.setMumpsIcntl(24, 1)
            if matrix_size(self.matrix) >= _LARGE:
                self._hasten(factor)
        elif not self._symmetric:
            factor.setMumpsIcntl(33, 1)  # its determinant
        return pc

    def _hasten(self, factor: Any) -> None:
        """Options by which inertia is found sooner; solutions may lose a digit to the first.

        Single precision is for matrices that are likely to be positive definite, which need no
        other pivots than their diagonal, and whose factors are tried before they are trusted.
        """
        if (unknowns := unknowns_of_nodes(self.matrix)) > 1:
            factor.setMumpsIcntl(15, -unknowns)  # the graph of the nodes is ordered
        if self.single:
            factor.setMumpsCntl(1, 0.0)
            factor.setMumpsIcntl(8, 0)
        else:  # panels, of which none is compressed
            factor.setMumpsIcntl(35, 2)
            factor.setMumpsCntl(7, 0.0)

    def solve(self, b: Any, x: Any, *, transposed: bool = False) -> None:
        """Solve A x = b, or A^T x = b, with PETSc vectors."""
        if transposed:
            self._pc.applyTranspose(b, x)
        else:
            self._pc.apply(b, x)

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """Solve for every column of b: the rows of this rank, shape (n_local, columns)."""
        solution = np.zeros(b.shape, order="F")
        layout, comm = self.matrix.getSizes()[0], self.matrix.comm
        right, left = dense(b, layout, comm), dense(solution, layout, comm)
        (self._pc.matApplyTranspose if transposed else self._pc.matApply)(right, left)
        destroy(right, left)
        return solution

    def steps(self) -> int:
        """One: the factors are its own."""
        return 1

    def negative_eigenvalues(self) -> int:
        """Number of negative eigenvalues of a symmetric A, by its inertia."""
        negative, _, _ = self._pc.getFactorMatrix().getInertia()
        return int(negative)

    def null_pivots(self) -> int:
        """Number of pivots that count as zero, where inertia was asked for."""
        _, zero, _ = self._pc.getFactorMatrix().getInertia()
        return int(zero)

    def sign(self) -> int:
        """Sign of the determinant of an unsymmetric A."""
        return int(np.sign(self._pc.getFactorMatrix().getMumpsRinfog(12)))

    def cost(self) -> tuple[float, float]:
        """Entries of the factors, and operations that they took."""
        factor = self._pc.getFactorMatrix()
        entries = factor.getMumpsInfog(29)  # below zero in millions
        return float(entries if entries >= 0 else -1e6 * entries), factor.getMumpsRinfog(3)

    def free(self) -> None:
        """Free the factors and the matrix."""
        destroy(self._pc, self.matrix)


class Refined:
    """A matrix solved by the factors of a nearby one and steps of iterative refinement.

    Each step leaves the part |I - F^-1 A| of an error: few steps suffice where F is near A.

    Parameters
    ----------
    matrix
        A, PETSc AIJ; it is destroyed with this object, the factors are not.
    near
        Factors of a matrix F near A.
    """

    _MOST_STEPS = 12
    _ROUNDING = 1e-15

    def __init__(self, matrix: Any, near: Factorisation) -> None:
        self.matrix = matrix
        self._near = near
        self._defect, self._correction = matrix.createVecs()

    def solve(self, b: Any, x: Any, *, transposed: bool = False) -> None:
        """Solve A x = b, or A^T x = b, with PETSc vectors, until rounding ends the progress."""
        self._refine(b, x, transposed=transposed)

    def _refine(self, b: Any, x: Any, *, transposed: bool = False) -> tuple[int, float]:
        """Steps taken, and the norm of the defect relative to that of b."""
        times = self.matrix.multTranspose if transposed else self.matrix.mult
        size, before = max(b.norm(), np.finfo(float).tiny), np.inf
        self._near.solve(b, x, transposed=transposed)
        for step in range(self._MOST_STEPS):
            times(x, self._defect)
            self._defect.aypx(-1.0, b)
            norm = self._defect.norm() / size
            if norm <= self._ROUNDING or norm > 0.5 * before:
                return step, norm
            self._near.solve(self._defect, self._correction, transposed=transposed)
            x.axpy(1.0, self._correction)
            before = norm
        return self._MOST_STEPS, before

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """Solve for every column of b: the rows of this rank, shape (n_local, columns)."""
        return _column_by_column(self, b, transposed=transposed)

    def steps(self) -> int:
        """Steps that a system of random numbers takes; very many where it is not solved."""
        x, b = self.matrix.createVecs()
        b.setRandom()
        steps, defect = self._refine(b, x)
        destroy(x, b)
        return steps if defect <= _SOLVED else sys.maxsize

    def free(self) -> None:
        """Free all but the factors."""
        destroy(self._defect, self._correction, self.matrix)


class Applied:
    """A factorisation as the context of a PETSc preconditioner.

    Parameters
    ----------
    factors
        What solves.
    transposed
        Whether it is the transposed matrix that is meant.
    """

    def __init__(self, factors: Factorisation, *, transposed: bool = False) -> None:
        self._factors, self._transposed = factors, transposed

    def apply(self, _: Any, b: Any, x: Any) -> None:
        """Solve with the matrix."""
        self._factors.solve(b, x, transposed=self._transposed)

    def applyTranspose(self, _: Any, b: Any, x: Any) -> None:
        """Solve with the transposed matrix."""
        self._factors.solve(b, x, transposed=not self._transposed)


def matrix_size(matrix: Any) -> int:
    """Number of rows over all ranks."""
    return int(matrix.getSize()[0])


def unknowns_of_nodes(matrix: Any) -> int:
    """Unknowns of each node where they follow each other, 3 or 2; else, or on several ranks, 1."""
    if matrix.comm.size > 1:
        return 1
    entries = np.diff(matrix.getRowIJ()[0])
    for unknowns in (3, 2):
        if len(entries) % unknowns == 0:
            nodes = entries.reshape(-1, unknowns)
            if (nodes == nodes[:, :1]).all(axis=1).mean() >= _SAME:
                return unknowns
    return 1


def _column_by_column(factors: Refined, b: Floats, *, transposed: bool) -> Floats:
    x, right = factors.matrix.createVecs()
    columns = np.empty_like(b)
    for i, column in enumerate(b.T):
        right.array[:] = column
        factors.solve(right, x, transposed=transposed)
        columns[:, i] = x.array_r
    destroy(x, right)
    return columns
