"""The eigenvalue driver: (lambda^2 M + S - F) x = 0 by shift-and-invert with SLEPc and MUMPS.

Undamped sliding is linear in kappa = -lambda^2: (S - F) x = kappa M x, with S = K + K_n symmetric
and F = K_f. Without friction it is solved as a symmetric problem. The driver takes operators, not
bodies; contact forces may be unknowns beside them (:mod:`cea.saddle`).
"""

from typing import Any

import numpy as np
from petsc4py import PETSc
from slepc4py import SLEPc

from cea.body import Floats
from cea.errors import ConvergenceError, InputError
from cea.modes import Complexes, Modes, Window
from cea.pencil import BorderedSolver, Pencil
from cea.saddle import Multipliers
from cea.timing import StageTimer

_MARGIN = 1.05
"""Radius of the searched disc relative to half the window: room for growth at its upper end."""
_SPARE = 2
"""Eigenvalues asked for beyond the inertia count."""
_MAX_PASSES = 8
"""Krylov runs, each larger than the last or beside the copies already found."""
_NEGLIGIBLE = 1e-10
"""Eigenvalues below this part of the window's upper end count as zero in relative residuals."""


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
        forces = None
        if bordered is not None:
            vectors, forces = _with_contact_forces(bordered, operator, mass, kappa, vectors, shift)
        modes = _modes(operator, mass, kappa, vectors, forces, window, symmetric=pencil.symmetric)
    solver.destroy()
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
    only. Where fewer are found than the inertia counts, a symmetric problem is searched again
    beside the vectors it has; an unsymmetric one, whose count friction may have changed, once more
    in a larger space.

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
        if not solver.isHermitian():
            wanted = min(size, len(kappa) + missing)
            larger = _krylov(solver, mass, wanted, 4 * wanted, timer)
            if len(larger[0]) > len(kappa):
                kappa, vectors = larger
                reached = min(reached, _reach(kappa, shift))
            break
        found = [_as_vector(mass, v.real) for v in vectors.T]
        solver.setDeflationSpace(found)
        copies, copy_vectors = _krylov(solver, mass, missing, missing + 16, timer)
        for vector in found:
            vector.destroy()
        kappa, vectors = np.append(kappa, copies), np.hstack([vectors, copy_vectors])
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


def _with_contact_forces(
    bordered: BorderedSolver,
    operator: Any,
    mass: Any,
    kappa: Complexes,
    vectors: Complexes,
    shift: float,
) -> tuple[Complexes, Complexes]:
    """One step of inverse iteration: displacements that obey the contact, and all forces on them.

    Returns
    -------
    tuple
        x and (S - F) x + L^T f, both normalised as the vectors were.
    """
    n = vectors.shape[1]
    inertia = _apply(mass, vectors * (kappa - shift))
    x, f = bordered.solve_block(np.hstack([inertia.real, inertia.imag]))
    displacements, contact = x[:, :n] + 1j * x[:, n:], f[:, :n] + 1j * f[:, n:]
    transpose = bordered.multipliers.reaction.transpose(PETSc.Mat())
    forces = _apply(operator, displacements) + _apply(transpose, contact)
    transpose.destroy()
    return displacements, forces


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
    real.destroy()
    imaginary.destroy()
    return values, vectors


def _modes(
    operator: Any,
    mass: Any,
    kappa: Complexes,
    vectors: Complexes,
    forces: Complexes | None,
    window: Window,
    *,
    symmetric: bool,
) -> Modes:
    mass_vectors = _apply(mass, vectors)
    if forces is None:
        forces = _apply(operator, vectors)
    norms = np.sqrt(_inner(vectors, mass_vectors, mass.comm, diagonal=True).real)
    vectors, mass_vectors, forces = vectors / norms, mass_vectors / norms, forces / norms
    if symmetric:  # the Rayleigh quotient has the square of the vector's error
        kappa = _inner(vectors, forces, mass.comm, diagonal=True).real.astype(complex)
    defects = forces - mass_vectors * kappa
    scale = np.maximum(np.abs(kappa), _NEGLIGIBLE * window.upper) * _norms(mass_vectors, mass.comm)
    residuals = _norms(defects, mass.comm) / scale
    conditions = np.ones(len(kappa))
    if not symmetric:
        conditions = _conditions(_inner(vectors, mass_vectors, mass.comm))

    eigenvalues = np.sqrt(-kappa).astype(complex)
    eigenvalues = np.where(eigenvalues.imag < 0, -eigenvalues, eigenvalues) + 0j
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
