"""The few eigenvalues nearest to a shift, by Krylov-Schur of SLEPc."""

from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.eigen.factorisation import Applied
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError
from cea.matrices import destroy
from cea.petsc import PETSc, SLEPc
from cea.timing import StageTimer


class NearestSearch:
    """Krylov-Schur runs of SLEPc on A(shift)^-1 M.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    factors
        The pencil factorised at the shift.
    tolerance
        Relative tolerance on 1 / (kappa - shift).
    max_restarts
        Restarts before a run is given up.
    timer
        Counts krylov.
    """

    def __init__(
        self,
        matrices: Matrices,
        factors: Shifted,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
    ) -> None:
        self._matrices = matrices
        self._size = matrices.size - matrices.tied
        self._shift = factors.kappa
        self._inverse = Applied(factors)
        self._limits = tolerance, max_restarts
        self._timer = timer

    def nearest(self, wanted: int) -> tuple[Complexes, Complexes]:
        """So many eigenvalues nearest to the shift, or a few more, and their vectors.

        Raises
        ------
        ConvergenceError
            When fewer converge.
        """
        wanted = min(wanted, self._size)
        kappa, vectors = self._krylov(wanted, 3 * wanted)
        if len(kappa) < wanted:
            raise ConvergenceError(f"{len(kappa)} of {wanted} eigenvalues converged", best=kappa)
        return kappa, vectors

    def _krylov(self, wanted: int, basis: int) -> tuple[Complexes, Complexes]:
        """One run for the eigenvalues nearest the shift."""
        solver = self._solver()
        ncv = min(basis, self._matrices.size)
        solver.setDimensions(nev=wanted, ncv=ncv, mpd=ncv)
        with self._timer("krylov"):
            solver.solve()
            kappa, vectors = _eigenpairs(solver, self._matrices.mass)
        destroy(solver)
        return kappa[: self._size], vectors[:, : self._size]  # ties have infinite ones, found last

    def _solver(self) -> Any:
        solver: Any = SLEPc.EPS().create(self._matrices.stiffness.comm)
        # Of K only the factors are used: the first operator stands for its size.
        solver.setOperators(self._matrices.stiffness, self._matrices.mass)
        kind: Any = SLEPc.EPS.ProblemType
        solver.setProblemType(kind.GHEP if self._matrices.symmetric else kind.GNHEP)
        solver.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
        solver.setPurify(False)  # the mass is nonsingular: nothing to purify
        solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
        solver.setTarget(self._shift)
        tolerance, max_restarts = self._limits
        solver.setTolerances(tol=tolerance, max_it=max_restarts)
        transform = solver.getST()
        transform.setType(SLEPc.ST.Type.SINVERT)
        transform.setShift(self._shift)
        transform.setMatMode(SLEPc.ST.MatMode.SHELL)
        krylov = transform.getKSP()
        krylov.setType(PETSc.KSP.Type.PREONLY)
        pc = krylov.getPC()
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(self._inverse)
        return solver


def _eigenpairs(solver: Any, mass: Any) -> tuple[Complexes, Complexes]:
    """Converged kappa and vectors; a complex pair is read once and its conjugate added."""
    converged = solver.getConverged()
    real, imaginary = mass.createVecRight(), mass.createVecRight()
    values = np.empty(converged, dtype=complex)
    vectors = np.empty((real.getLocalSize(), converged), dtype=complex, order="F")
    i = 0
    while i < converged:
        values[i] = solver.getEigenpair(i, real, imaginary)
        vectors[:, i] = real.array
        if values[i].imag != 0:
            vectors[:, i] += 1j * imaginary.array
            if i + 1 < converged:
                values[i + 1], vectors[:, i + 1] = values[i].conj(), vectors[:, i].conj()
            i += 1
        i += 1
    destroy(real, imaginary)
    return values, vectors
