"""The eigenvalue driver: (lambda^2 M + S - F) x = 0 by shift-and-invert with SLEPc and MUMPS.

Undamped sliding is linear in kappa = -lambda^2: (S - F) x = kappa M x, with S = K + K_n symmetric
and F = K_f. Without friction it is solved as a symmetric problem. The driver takes operators, not
bodies.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from slepc4py import SLEPc

from cea.body import Floats
from cea.errors import ConvergenceError, InputError
from cea.timing import StageTimer

Complexes = NDArray[np.complex128]

_MARGIN = 1.05
"""Radius of the searched disc relative to half the window: room for growth at its upper end."""
_SPARE = 2
"""Eigenvalues asked for beyond the inertia count."""
_MAX_ENLARGEMENTS = 6
_NEGLIGIBLE = 1e-10
"""Eigenvalues below this part of the window's upper end count as zero in relative residuals."""


@dataclass(frozen=True)
class Window:
    """What was searched, and why it is believed complete.

    Parameters
    ----------
    max_frequency
        Upper end (Hz) of the modes asked for.
    shift
        Centre sigma of the searched disc of kappa (1/s^2).
    radius
        Every kappa with abs(kappa - shift) < radius was found (1/s^2).
    found
        Number of eigenvalues in the disc.
    upper
        Upper end of kappa for the count (1/s^2), a little above the window's.
    found_below
        Eigenvalues found with Re kappa below ``upper``.
    symmetric_count
        Eigenvalues of S x = kappa M x, without friction, below ``upper``, by inertia.
    max_growth
        Largest growth rate (1/s) a mode at the upper end can have and still lie in the disc.
    """

    max_frequency: float
    shift: float
    radius: float
    found: int
    upper: float
    found_below: int
    symmetric_count: int
    max_growth: float

    @property
    def evidence(self) -> str:
        """Why the window is believed complete, in words."""
        return (
            f"shift-and-invert converged outwards to all {self.found} eigenvalues in the disc "
            f"|kappa - {self.shift:.5g}| <= {self.radius:.5g}; below kappa = {self.upper:.5g} "
            f"it found {self.found_below}, and the inertia of the symmetric part counts "
            f"{self.symmetric_count}"
        )


@dataclass(frozen=True)
class Modes:
    """Modes by rising frequency, Im lambda >= 0.

    Parameters
    ----------
    eigenvalues
        lambda (1/s), shape (n,): growth rate + i * angular frequency.
    residuals
        Norm of (S - F - kappa M) x relative to abs(kappa) times that of M x, shape (n,).
    conditions
        Condition numbers of kappa in the M-norm within the computed invariant subspace, shape
        (n,): 1 for a symmetric problem, large near a coalescence.
    vectors
        Eigenvectors x with x^H M x = 1, the rows of this rank, shape (n_local, n).
    template
        PETSc vector of their layout.
    window
        What was searched.
    """

    eigenvalues: Complexes
    residuals: Floats
    conditions: Floats
    vectors: Complexes
    template: Any
    window: Window

    @property
    def frequencies(self) -> Floats:
        """Frequencies (Hz)."""
        return self.eigenvalues.imag / (2 * np.pi)

    @property
    def growth_rates(self) -> Floats:
        """Growth rates Re lambda (1/s)."""
        return self.eigenvalues.real

    @property
    def growth_uncertainties(self) -> Floats:
        """Growth rates (1/s) that backward error times condition can explain.

        d lambda = d kappa / (2 abs(lambda)), and at a near-double eigenvalue an error e of kappa
        shows as its square root; the condition number carries that.
        """
        kappa = np.abs(self.eigenvalues) ** 2
        floor = np.maximum(np.abs(self.eigenvalues), np.finfo(float).tiny)
        error = np.maximum(self.residuals, np.finfo(float).eps) * self.conditions * kappa
        return np.minimum(error / (2 * floor), np.sqrt(error))

    def unstable(self, threshold: float = 0.0) -> NDArray[np.bool_]:
        """Modes that grow faster than a threshold (1/s) and than their errors explain, (n,)."""
        return self.growth_rates > np.maximum(threshold, self.growth_uncertainties)

    def vector(self, mode: int) -> tuple[Any, Any]:
        """Real and imaginary part of an eigenvector as PETSc vectors."""
        real, imaginary = self.template.duplicate(), self.template.duplicate()
        real.array[:] = self.vectors[:, mode].real
        imaginary.array[:] = self.vectors[:, mode].imag
        return real, imaginary


def solve_modes(
    stiffness: Any,
    mass: Any,
    friction: Any | None = None,
    *,
    max_frequency: float,
    tolerance: float = 1e-10,
    max_restarts: int = 200,
    timer: StageTimer | None = None,
) -> Modes:
    """All modes up to a frequency.

    Parameters
    ----------
    stiffness
        Symmetric part S, PETSc AIJ (N/m).
    mass
        Symmetric positive definite M, PETSc AIJ (kg).
    friction
        Unsymmetric part F, PETSc AIJ (N/m); None takes the symmetric path.
    max_frequency
        Upper end of the modes asked for (Hz).
    tolerance
        Relative tolerance of the Krylov iteration on 1 / (kappa - shift).
    max_restarts
        Restarts of the Krylov iteration before it is given up.
    timer
        Counts factorisation, krylov and post-processing.

    Raises
    ------
    ConvergenceError
        When the window cannot be filled; the modes found so far are attached.
    """
    if not max_frequency > 0:
        raise InputError("max_frequency", max_frequency, "a positive number (Hz)")
    timer = timer or StageTimer()
    top = (2 * np.pi * max_frequency) ** 2
    shift, radius = 0.5 * top, 0.5 * top * _MARGIN

    with timer("factorisation"):
        count = count_below(stiffness, mass, shift + radius)
    operator = stiffness
    if friction is not None:
        operator = stiffness.copy()
        operator.axpy(-1.0, friction, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    solver = _shift_invert(operator, mass, shift, symmetric=friction is None)
    solver.setTolerances(tol=tolerance, max_it=max_restarts)

    size = operator.getSize()[0]
    wanted = min(count + _SPARE, size)
    for _ in range(_MAX_ENLARGEMENTS):
        solver.setDimensions(nev=wanted, ncv=min(max(2 * wanted, wanted + 16), size))
        with timer("factorisation"):
            solver.setUp()
        with timer("krylov"):
            solver.solve()
        kappa, vectors = _eigenpairs(solver, mass)
        reached = np.abs(kappa - shift).max() if len(kappa) else 0.0
        if len(kappa) >= size:
            reached = np.inf
        if reached >= radius or len(kappa) < wanted:
            break
        wanted = min(size, wanted + max(4, wanted // 4))

    with timer("post-processing"):
        window = Window(
            max_frequency=max_frequency,
            shift=shift,
            radius=float(reached),
            found=int(np.sum(np.abs(kappa - shift) <= reached)),
            upper=shift + radius,
            found_below=int(np.sum(kappa.real < shift + radius)),
            symmetric_count=count,
            max_growth=_growth_covered(top, shift, float(reached)),
        )
        modes = _modes(operator, mass, kappa, vectors, window, symmetric=friction is None)
    solver.destroy()
    if reached < radius:
        raise ConvergenceError(
            f"{len(kappa)} of {wanted} eigenvalues converged; they fill a disc of radius "
            f"{reached:.4g} about kappa = {shift:.4g}, {radius:.4g} is needed for every mode to "
            f"{max_frequency:g} Hz",
            best=modes,
        )
    if friction is None and window.found_below != count:
        raise ConvergenceError(
            f"{window.found_below} eigenvalues found below kappa = {window.upper:.6g}, "
            f"the inertia of S - kappa M counts {count}",
            best=modes,
        )
    return modes


def count_below(stiffness: Any, mass: Any, kappa: float) -> int:
    """Number of eigenvalues of S x = kappa' M x below kappa, by the inertia of S - kappa M.

    Parameters
    ----------
    stiffness, mass
        Symmetric S and symmetric positive definite M, PETSc AIJ.
    kappa
        Upper end (1/s^2).
    """
    shifted = stiffness.copy()
    shifted.axpy(-kappa, mass, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
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
    negative, _, _ = factor.getInertia()
    pc.destroy()
    shifted.destroy()
    return int(negative)


def _shift_invert(operator: Any, mass: Any, shift: float, *, symmetric: bool) -> Any:
    solver = SLEPc.EPS().create(operator.comm)
    solver.setOperators(operator, mass)
    solver.setProblemType(SLEPc.EPS.ProblemType.GHEP if symmetric else SLEPc.EPS.ProblemType.GNHEP)
    solver.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    solver.setTarget(shift)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    transform.setShift(shift)
    transform.setMatStructure(PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
    krylov = transform.getKSP()
    krylov.setType(PETSc.KSP.Type.PREONLY)
    pc = krylov.getPC()
    pc.setType(PETSc.PC.Type.CHOLESKY if symmetric else PETSc.PC.Type.LU)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    return solver


def _eigenpairs(solver: Any, mass: Any) -> tuple[Complexes, Complexes]:
    """Converged kappa and vectors; a complex pair is read once and its conjugate added."""
    converged = solver.getConverged()
    real, imaginary = mass.createVecRight(), mass.createVecRight()
    values = np.empty(converged, dtype=complex)
    vectors = np.empty((real.getLocalSize(), converged), dtype=complex)
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
    return values, vectors


def _modes(
    operator: Any,
    mass: Any,
    kappa: Complexes,
    vectors: Complexes,
    window: Window,
    *,
    symmetric: bool,
) -> Modes:
    eigenvalues = np.sqrt(-kappa).astype(complex)
    eigenvalues = np.where(eigenvalues.imag < 0, -eigenvalues, eigenvalues) + 0j
    mass_vectors = _apply(mass, vectors)
    norms = np.sqrt(_inner(vectors, mass_vectors, mass.comm, diagonal=True).real)
    vectors, mass_vectors = vectors / norms, mass_vectors / norms
    defects = _apply(operator, vectors) - mass_vectors * kappa
    scale = np.maximum(np.abs(kappa), _NEGLIGIBLE * window.upper) * _norms(mass_vectors, mass.comm)
    residuals = _norms(defects, mass.comm) / scale
    conditions = np.ones(len(kappa))
    if not symmetric:
        conditions = _conditions(_inner(vectors, mass_vectors, mass.comm))

    order = np.lexsort((eigenvalues.real, eigenvalues.imag))
    order = order[eigenvalues.imag[order] <= 2 * np.pi * window.max_frequency]
    return Modes(
        eigenvalues=eigenvalues[order],
        residuals=residuals[order],
        conditions=conditions[order],
        vectors=vectors[:, order],
        template=mass.createVecRight(),
        window=window,
    )


def _growth_covered(top: float, shift: float, radius: float) -> float:
    """Largest Re lambda at Im lambda = sqrt(top) with abs(-lambda^2 - shift) <= radius."""
    if not np.isfinite(radius):
        return float("inf")
    b, c = 2 * (top + shift), (top - shift) ** 2 - radius**2
    square = 0.5 * (-b + np.sqrt(b * b - 4 * c))
    return float(np.sqrt(max(square, 0.0)))


def _apply(matrix: Any, vectors: Complexes) -> Complexes:
    """Matrix times a block of vectors, real and imaginary parts in one sparse-dense product."""
    n = vectors.shape[1]
    block = np.asfortranarray(np.hstack([vectors.real, vectors.imag]))
    columns = matrix.getSizes()[1]
    dense = PETSc.Mat().createDense((columns, (PETSc.DECIDE, 2 * n)), array=block, comm=matrix.comm)
    product = matrix.matMult(dense)
    result = np.array(product.getDenseArray())
    product.destroy()
    dense.destroy()
    return result[:, :n] + 1j * result[:, n:]


def _inner(left: Complexes, right: Complexes, comm: Any, *, diagonal: bool = False) -> Complexes:
    local = np.einsum("ij,ij->j", left.conj(), right) if diagonal else left.conj().T @ right
    return comm.tompi4py().allreduce(local)


def _norms(vectors: Complexes, comm: Any) -> Floats:
    return np.sqrt(_inner(vectors, vectors, comm, diagonal=True).real)


def _conditions(gram: Complexes) -> Floats:
    """Condition numbers from the Gram matrix of unit eigenvectors: sqrt of diag of its inverse."""
    inverse = np.linalg.pinv(gram, hermitian=True, rcond=1e-30)
    return np.sqrt(np.maximum(np.diag(inverse).real, 1.0))
