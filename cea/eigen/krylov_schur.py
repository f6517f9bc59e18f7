"""The eigenvalue driver: (lambda^2 M + S - F) x = 0 by shift-and-invert with SLEPc and MUMPS.

Undamped sliding is linear in kappa = -lambda^2: (S - F) x = kappa M x, with S = K + K_n symmetric
and F = K_f. Without friction it is solved as a symmetric problem. The driver takes operators, not
bodies; contact forces may be unknowns beside them (:mod:`cea.contact.saddle`).
"""

from typing import Any

import numpy as np

from cea.body import Floats
from cea.contact.saddle import Multipliers
from cea.eigen.eigenpairs import modes_from_eigenpairs
from cea.eigen.modes import Complexes, Modes, Window
from cea.eigen.pencil import BorderedSolver, Pencil
from cea.errors import ConvergenceError, InputError
from cea.matrices import destroy
from cea.petsc import PETSc, SLEPc
from cea.timing import StageTimer

_MARGIN = 1.05
"""Radius of the searched disc relative to half the window: room for growth at its upper end."""
_SPARE = 2
"""Eigenvalues asked for beyond the inertia count."""
_MAX_PASSES = 8
"""Krylov runs, each larger than the last or beside the copies already found."""


def solve_modes(
    stiffness: Any,
    mass: Any,
    friction: Any | None = None,
    *,
    max_frequency: float,
    multipliers: Multipliers | None = None,
    tolerance: float = 1e-13,
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
    multipliers
        Contact forces that are unknowns; K_n and K_f of their contacts are not in S and F.
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

    pencil = Pencil(stiffness, mass, friction, multipliers)
    with timer("factorisation"):
        count = pencil.count_below(shift + radius)
    operator = pencil.displacement_operator()
    solver = _shift_invert(operator, mass, shift, symmetric=pencil.symmetric)
    bordered = None
    if multipliers is not None:
        with timer("factorisation"):
            bordered = pencil.bordered(shift)
        _precondition(solver, bordered)
    solver.setTolerances(tol=tolerance, max_it=max_restarts)
    kappa, vectors, reached = _search(solver, mass, shift, radius, count, timer)

    solver.destroy()  # with its Krylov space, before vectors of the same size are worked on

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
        modes = modes_from_eigenpairs(
            operator, mass, kappa, vectors, window, symmetric=pencil.symmetric, bordered=bordered
        )
    if bordered is not None:
        bordered.free()
    if operator is not stiffness:
        operator.destroy()
    if reached < radius:
        raise ConvergenceError(
            f"{len(kappa)} eigenvalues converged; they fill a disc of radius {reached:.4g} "
            f"about kappa = {shift:.4g}, {radius:.4g} is needed for every mode to "
            f"{max_frequency:g} Hz",
            best=modes,
        )
    if pencil.symmetric and window.found_below != count:
        raise ConvergenceError(
            f"{window.found_below} eigenvalues found below kappa = {window.upper:.6g}, "
            f"the inertia of S - kappa M counts {count}",
            best=modes,
        )
    return modes


def _search(
    solver: Any, mass: Any, shift: float, radius: float, count: int, timer: StageTimer
) -> tuple[Complexes, Complexes, float]:
    """Eigenpairs outwards from the shift until the disc is full.

    A Krylov space holds one vector of a multiple eigenvalue and meets further copies by rounding
    only. Where fewer are found than the inertia counts, it is searched beside those found: a
    symmetric problem has then more of them. An unsymmetric one may have lost them to friction; if
    not, it is searched once more in a larger space.

    Returns
    -------
    tuple
        kappa, vectors, and the radius of the disc that is full.
    """
    size = mass.getSize()[0]
    wanted = min(count + _SPARE, size)
    kappa, vectors = _krylov(solver, mass, wanted, 2 * wanted, timer)
    for _ in range(_MAX_PASSES):
        if len(kappa) < wanted or wanted == size or _reach(kappa, shift) >= radius:
            break
        wanted = min(size, wanted + max(4, wanted // 4))
        kappa, vectors = _krylov(solver, mass, wanted, 2 * wanted, timer)
    reached = np.inf if len(kappa) >= size else _reach(kappa, shift)

    for _ in range(_MAX_PASSES):
        missing = count - int(np.sum(kappa.real < shift + radius))
        if missing <= 0 or reached < radius:
            break
        others, other_vectors = _krylov_beside(solver, mass, kappa, vectors, missing, timer)
        if solver.isHermitian():
            kappa, vectors = np.append(kappa, others), np.hstack([vectors, other_vectors])
            continue
        if (np.abs(others - shift) < radius).any():
            wanted = min(size, len(kappa) + missing)
            larger = _krylov(solver, mass, wanted, 4 * wanted, timer)
            if len(larger[0]) > len(kappa):
                kappa, vectors = larger
                reached = min(reached, _reach(kappa, shift))
        break
    return kappa, vectors, float(reached)


def _krylov(
    solver: Any, mass: Any, wanted: int, basis: int, timer: StageTimer
) -> tuple[Complexes, Complexes]:
    """One Krylov-Schur run for the eigenvalues nearest the shift."""
    size = mass.getSize()[0]
    ncv = min(max(basis, wanted + 16), size)
    solver.setDimensions(nev=wanted, ncv=ncv, mpd=ncv)
    with timer("factorisation"):
        solver.setUp()
    with timer("krylov"):
        solver.solve()
        return _eigenpairs(solver, mass)


def _krylov_beside(
    solver: Any,
    mass: Any,
    kappa: Complexes,
    vectors: Complexes,
    wanted: int,
    timer: StageTimer,
) -> tuple[Complexes, Complexes]:
    """Eigenvalues nearest the shift beside the invariant subspace of eigenpairs already found.

    They are eigenvalues of the whole problem; their vectors are eigenvectors only if it is
    symmetric.
    """
    pairs = vectors[:, kappa.imag > 0].imag
    found = [_as_vector(mass, v) for v in vectors[:, kappa.imag >= 0].real.T]
    found += [_as_vector(mass, v) for v in pairs.T]
    beside = SLEPc.EPS().create(solver.comm)
    beside.setST(solver.getST())  # with its factorisation
    beside.setProblemType(solver.getProblemType())
    beside.setPurify(False)
    beside.setWhichEigenpairs(solver.getWhichEigenpairs())
    beside.setTarget(solver.getTarget())
    tolerance, max_restarts = solver.getTolerances()
    beside.setTolerances(tol=tolerance, max_it=max_restarts)
    beside.setDeflationSpace(found)
    result = _krylov(beside, mass, wanted, 2 * wanted, timer)
    destroy(beside, *found)
    return result


def _reach(kappa: Complexes, shift: float) -> float:
    return float(np.abs(kappa - shift).max(initial=0.0))


def _as_vector(mass: Any, values: Floats) -> Any:
    vector = mass.createVecRight()
    vector.array[:] = values
    return vector


def _shift_invert(operator: Any, mass: Any, shift: float, *, symmetric: bool) -> Any:
    solver = SLEPc.EPS().create(operator.comm)
    solver.setOperators(operator, mass)
    solver.setProblemType(SLEPc.EPS.ProblemType.GHEP if symmetric else SLEPc.EPS.ProblemType.GNHEP)
    solver.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    solver.setPurify(False)  # the mass is nonsingular: nothing to purify
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


def _precondition(solver: Any, bordered: BorderedSolver) -> None:
    """Take displacements from the bordered system instead of the displacement operator alone."""
    pc = solver.getST().getKSP().getPC()
    pc.setType(PETSc.PC.Type.PYTHON)
    pc.setPythonContext(bordered)


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
    real.destroy()
    imaginary.destroy()
    return values, vectors


def _growth_covered(top: float, shift: float, radius: float) -> float:
    """Largest Re lambda at Im lambda = sqrt(top) with abs(-lambda^2 - shift) <= radius."""
    if not np.isfinite(radius):
        return float("inf")
    b, c = 2 * (top + shift), (top - shift) ** 2 - radius**2
    square = 0.5 * (-b + np.sqrt(b * b - 4 * c))
    return float(np.sqrt(max(square, 0.0)))
