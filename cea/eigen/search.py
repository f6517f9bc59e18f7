"""Search for the eigenvalues around a shift, outwards until a disc is full."""

from typing import Any

import numpy as np

from cea.body import Complexes, Floats
from cea.eigen.factorisation import Applied
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError
from cea.matrices import destroy
from cea.petsc import PETSc, SLEPc
from cea.timing import StageTimer

_SPARE = 2
"""Eigenvalues asked for beyond the inertia count."""
_MAX_PASSES = 8
"""Krylov runs, each larger than the last or beside the copies already found."""


class Search:
    """Krylov-Schur runs of SLEPc on A(shift)^-1 M, or on its transposed problem.

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

    def disc(self, radius: float, count: int) -> tuple[Complexes, Complexes, float]:
        """Eigenpairs outwards from the shift until the disc is full.

        A Krylov space holds one vector of a multiple eigenvalue and meets further copies by
        rounding only. Where fewer are found than the inertia counts, it is searched beside those
        found: a symmetric problem has then more of them. An unsymmetric one may have lost them to
        friction; if not, it is searched once more in a larger space.

        Parameters
        ----------
        radius
            Radius of the disc (1/s^2).
        count
            Eigenvalues that are expected below its upper end.

        Returns
        -------
        tuple
            kappa, vectors, and the radius of the disc that is full.
        """
        size = self._size
        wanted = min(count + _SPARE, size)
        kappa, vectors = self._krylov(wanted, _basis(wanted))
        for _ in range(_MAX_PASSES):
            if len(kappa) < wanted or wanted == size or self._reach(kappa) >= radius:
                break
            wanted = min(size, wanted + max(4, wanted // 4))
            kappa, vectors = self._krylov(wanted, _basis(wanted))
        reached = np.inf if len(kappa) >= size else self._reach(kappa)

        for _ in range(_MAX_PASSES):
            missing = count - int(np.sum(kappa.real < self._shift + radius))
            if missing <= 0 or reached < radius or len(kappa) >= size:
                break
            others, beside = self._krylov(missing, _basis(missing), found=(kappa, vectors))
            if self._matrices.symmetric:
                kappa, vectors = np.append(kappa, others), np.hstack([vectors, beside])
                continue
            if (np.abs(others - self._shift) < radius).any():
                wanted = min(size, len(kappa) + missing)
                larger = self._krylov(wanted, max(4 * wanted, wanted + 16))
                if len(larger[0]) > len(kappa):
                    kappa, vectors = larger
                    reached = min(reached, self._reach(kappa))
            break
        return kappa, vectors, float(reached)

    def _reach(self, kappa: Complexes) -> float:
        return float(np.abs(kappa - self._shift).max(initial=0.0))

    def _krylov(
        self, wanted: int, basis: int, found: tuple[Complexes, Complexes] | None = None
    ) -> tuple[Complexes, Complexes]:
        """One run for the eigenvalues nearest the shift.

        Beside eigenpairs already found, the run stays outside their invariant subspace: what it
        finds are eigenvalues of the whole problem, its vectors eigenvectors only if that is
        symmetric.
        """
        solver = self._solver()
        size = self._matrices.size
        ncv = min(basis, size)
        solver.setDimensions(nev=wanted, ncv=ncv, mpd=ncv)
        deflated = _real_basis(self._matrices.mass, *found) if found is not None else []
        if deflated:
            solver.setDeflationSpace(deflated)
        with self._timer("krylov"):
            solver.solve()
            kappa, vectors = _eigenpairs(solver, self._matrices.mass)
        destroy(solver, *deflated)
        finite = self._size - (len(found[0]) if found is not None else 0)
        return kappa[:finite], vectors[:, :finite]  # ties have infinite ones, found last

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


def _basis(wanted: int) -> int:
    """Vectors of a Krylov space in which so many eigenvalues converge."""
    return max(2 * wanted, wanted + 16)


def _real_basis(mass: Any, kappa: Complexes, vectors: Complexes) -> list[Any]:
    """Real PETSc vectors that span eigenvectors with their conjugates."""
    columns = [*vectors[:, kappa.imag >= 0].real.T, *vectors[:, kappa.imag > 0].imag.T]
    return [_as_vector(mass, column) for column in columns]


def _as_vector(mass: Any, values: Floats) -> Any:
    vector = mass.createVecRight()
    vector.array[:] = values
    return vector


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
