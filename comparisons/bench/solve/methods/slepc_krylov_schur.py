"""Krylov-Schur of SLEPc with MUMPS, used as its manual shows."""

from typing import Any

import numpy as np

from cea.petsc import PETSc, SLEPc
from comparisons.bench.solve.methods.method import Answer
from comparisons.bench.solve.methods.problem import Problem

TOLERANCE = 1e-12


def solve(problem: Problem) -> Answer:
    """As many eigenvalues as are wanted, those nearest to the shift."""
    solver: Any = SLEPc.EPS().create(problem.mass.comm)
    solver.setOperators(problem.unsymmetric(), problem.mass)
    solver.setProblemType(SLEPc.EPS.ProblemType.PGNHEP)
    return _solved(solver, problem.shift, problem.count, PETSc.PC.Type.LU)


def symmetric_modes(problem: Problem, count: int) -> Answer:
    """The lowest modes of the symmetric part, of which there are so many."""
    solver: Any = SLEPc.EPS().create(problem.mass.comm)
    solver.setOperators(problem.stiffness, problem.mass)
    solver.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    return _solved(solver, 0.0, count, PETSc.PC.Type.CHOLESKY)


def _solved(solver: Any, shift: float, count: int, factorisation: Any) -> Answer:
    solver.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    solver.setDimensions(nev=count)
    solver.setTolerances(tol=TOLERANCE)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    solver.setTarget(shift)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    inner = transform.getKSP()
    inner.setType(PETSc.KSP.Type.PREONLY)
    inner.getPC().setType(factorisation)
    inner.getPC().setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    solver.solve()
    return _pairs(solver, solver.getOperators()[1])


def _pairs(solver: Any, mass: Any) -> Answer:
    """Converged eigenpairs; SLEPc lists both of a conjugate pair."""
    real, imaginary = mass.createVecs()
    count = solver.getConverged()
    kappa = np.empty(count, dtype=complex)
    vectors = np.empty((real.getLocalSize(), count), dtype=complex, order="F")
    for i in range(count):
        kappa[i] = solver.getEigenpair(i, real, imaginary)
        vectors[:, i] = real.array_r + 1j * imaginary.array_r
    return Answer(kappa, vectors, f"{count} nearest to the shift")
