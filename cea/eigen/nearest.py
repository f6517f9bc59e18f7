"""The few eigenvalues nearest to a shift, by Krylov-Schur of SLEPc."""

from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
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
    transposed
        Whether eigenvectors of K^T are searched: left ones, of conjugate eigenvalues.
    """

    def __init__(
        self,
        matrices: Matrices,
        factors: Shifted,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
        *,
        transposed: bool = False,
    ) -> None:
        self._matrices = matrices
        self._size = matrices.size - matrices.tied
        self._shift = factors.kappa
        self._inverse = Applied(factors, transposed=transposed)
        self._limits = tolerance, max_restarts
        self._timer = timer

    def nearest(
        self, wanted: int, known: Floats | None = None, seed: int | None = None
    ) -> tuple[Complexes, Complexes]:
        """So many eigenvalues nearest to the shift, or a few more, and their vectors.

        Parameters
        ----------
        wanted
            How many.
        known
            Vectors of an invariant subspace that is left out, the rows of this rank; the others
            are then eigenvectors beside it.
        seed
            Of a random start vector; None leaves it to SLEPc.

        Raises
        ------
        ConvergenceError
            When fewer converge.
        """
        left_out = 0 if known is None else known.shape[1]
        size = self._size - left_out
        wanted = min(wanted, size)
        solver = self._solver()
        ncv = min(3 * wanted, self._matrices.size - left_out)
        solver.setDimensions(nev=wanted, ncv=ncv, mpd=ncv)
        if known is not None and left_out:
            self._leave_out(solver, known)
        if seed is not None:
            self._begin(solver, seed)
        with self._timer("krylov"):
            solver.solve()
            kappa, vectors = _eigenpairs(solver, self._matrices.mass)
        destroy(solver)
        if len(kappa) < wanted:
            raise ConvergenceError(f"{len(kappa)} of {wanted} eigenvalues converged", best=kappa)
        return kappa[:size], vectors[:, :size]  # ties have infinite ones, found last

    def _leave_out(self, solver: Any, known: Floats) -> None:
        space = []
        for column in known.T:
            vector = self._matrices.mass.createVecRight()
            vector.array[:] = column
            space.append(vector)
        solver.setDeflationSpace(space)
        destroy(*space)

    def _begin(self, solver: Any, seed: int) -> None:
        vector = self._matrices.mass.createVecRight()
        random = np.random.default_rng([seed, vector.comm.rank])
        vector.array[:] = random.standard_normal(vector.getLocalSize())
        solver.setInitialSpace([vector])
        destroy(vector)

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
