"""From what a search found to modes: with their errors, and with left vectors where wanted."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.linalg import LinAlgError
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen import quadratic_two_sided, two_sided
from cea.eigen.blocks import all_inner, times
from cea.eigen.classify import cannot_grow
from cea.eigen.clusters import cluster_bounds
from cea.eigen.coverage import upper_end
from cea.eigen.eigenpairs import checked
from cea.eigen.eigenvalue_matching import DEGENERATE, assign, group
from cea.eigen.modes import Modes, modes_of, refuse_what_is_lost, warnings_of
from cea.eigen.pencil import Matrices, Pencil
from cea.eigen.quadratic_damping import Damping
from cea.eigen.quadratic_pairs import QuadraticPairs, checked_pairs, inverse_step, upper_half
from cea.eigen.quadratic_window import QuadraticNeighbours, QuadraticWindow
from cea.eigen.sensitivity import SAME, LeftVectors, dual_norms, left_vectors_of
from cea.eigen.shift_invert import MARGIN, Undamped
from cea.eigen.shifted import Shifted
from cea.eigen.spectrum import SLOW, Window, nearest_window
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.window import DampedSearch, Found, WindowSearch
from cea.errors import ConvergenceError
from cea.timing import StageTimer


@dataclass(frozen=True)
class EigenProblem:
    """What is solved.

    Parameters
    ----------
    pencil, values, matrices
        A pencil, the parameters it is solved at, and its sums there.
    end
        omega of the end of the window (1/s); of the modes nearest to a place its modulus.
    timer
        Counts the stages.
    """

    pencil: Pencil
    values: Mapping[str, float]
    matrices: Matrices
    end: float
    timer: StageTimer

    def nearest_modes(self, found: InvariantSubspace, op: Undamped) -> Modes:
        """Modes of what was found next to a place, which is no window."""
        with self.timer("post-processing"):
            if self.matrices.quadratic:
                subspace = upper_half(found, self.end)
                pairs = checked_pairs(self.matrices, op.factors, subspace, self.end)
                place = QuadraticNeighbours.of(op.shift, pairs.eigenvalues)
                return _damped_modes(self, pairs, None, place)
            kappa, vectors = found.eigenpairs()
            own = checked(self.matrices, op.factors, kappa, vectors)
            window = nearest_window(op.shift, kappa)
            return modes_of(self.pencil, self.values, self.matrices, own, None, window)


def modes_found(
    problem: EigenProblem, found: Found, search: WindowSearch, *, left: bool | None
) -> Modes:
    """Modes of what was found in a window, with their errors.

    Parameters
    ----------
    problem
        What was solved.
    found
        What was found.
    search
        What searches left vectors where they are wanted, or errors cannot be told without.
    left
        Whether left vectors are wanted; None searches none whatever was found.
    """
    kind = _damped if problem.matrices.quadratic else _undamped
    return kind(problem, found, search, left)


def _undamped(
    problem: EigenProblem, found: Found, search: WindowSearch, left: bool | None
) -> Modes:
    matrices, timer, subspace = problem.matrices, problem.timer, found.subspace
    top = problem.end**2
    factors = search.near.factors
    with timer("post-processing"):  # those around the window show too what rounding does
        kappa, vectors = subspace.eigenpairs()
        window = _window(found, problem.end, kappa)
        pairs = checked(matrices, factors, kappa, vectors, subspace.conditions())
        if not matrices.symmetric:
            bounds = cluster_bounds(subspace.projected, pairs.kappa, pairs.errors, pairs.conditions)
            pairs = replace(pairs, bounds=bounds)
        unsure = left is not None and two_sided.one_sided(matrices, factors, subspace, pairs)
    left_vectors = None
    if left or unsure:
        try:
            if not matrices.symmetric:
                kappa, vectors = search.left()
            with timer("post-processing"):
                factors = search.near.factors
                left_vectors = left_vectors_of(matrices, factors, pairs, kappa, vectors, top)
        except (ConvergenceError, LinAlgError):
            if left or not unsure:
                raise
    with timer("post-processing"):
        if left and left_vectors is not None and not (matrices.symmetric or subspace.graded):
            conditions = dual_norms(matrices.mass, left_vectors.vectors)
            pairs = replace(pairs, conditions=conditions)
        if unsure:
            both = None if left_vectors is None else (kappa, left_vectors)
            pairs = two_sided.judged_by_both(matrices, subspace, pairs, both, top)
        wanted = left_vectors if left else None
        return modes_of(problem.pencil, problem.values, matrices, pairs, wanted, window)


def _window(found: Found, end: float, kappa: Complexes) -> Window:
    """The window, and why it is believed complete; without damping."""
    upper, disc = upper_end(end**2), found.discs[0] if found.discs else None
    return Window(
        max_frequency=end / (2 * np.pi),
        shift=disc.centre if disc else 0.5 * end**2,
        radius=disc.radius if disc else 0.0,
        found=len(kappa),
        discs=len(found.discs),
        max_growth=np.inf if found.bounded else found.growth,
        bounded=found.bounded,
        odd=found.odd,
        upper=upper,
        found_below=int(np.sum(kappa.real < upper)),
        symmetric_count=found.counted,
    )


def _damped(problem: EigenProblem, found: Found, search: WindowSearch, left: bool | None) -> Modes:
    matrices, timer, end = problem.matrices, problem.timer, problem.end
    assert isinstance(search, DampedSearch)
    factors = search.near.factors
    with timer("post-processing"):
        subspace = upper_half(found.subspace, end)
        pairs = checked_pairs(matrices, factors, subspace, end)
        unsure = left is not None and quadratic_two_sided.one_sided(
            matrices, factors, subspace, pairs, end
        )
    both = None
    if left or unsure:
        try:
            values, vectors = search.left()
            with timer("post-processing"):
                x = vectors[: len(vectors) // 2]
                both = values, _left_vectors(problem, search.near.factors, pairs, values, x)
        except (ConvergenceError, LinAlgError):
            if left:
                raise
    with timer("post-processing"):
        if left and both is not None:
            slopes = dual_norms(matrices.mass, both[1].vectors)
            with np.errstate(divide="ignore", invalid="ignore"):
                slopes = slopes / (2 * np.abs(pairs.eigenvalues))
            pairs = replace(pairs, slopes=np.where(np.isfinite(slopes), slopes, pairs.slopes))
        if unsure:
            pairs = quadratic_two_sided.judged_by_both(matrices, subspace, pairs, both, end)
        inside = (pairs.eigenvalues.imag >= 0) & (pairs.eigenvalues.imag <= end)
        first = found.discs[0] if found.discs else None
        window = QuadraticWindow(
            max_frequency=end / (2 * np.pi),
            shift=first.centre if first else 0.0,
            radius=first.radius if first else 0.0,
            found=subspace.size,
            discs=len(found.discs),
            max_growth=np.inf if found.bounded else found.growth,
            bounded=found.bounded,
            odd=found.odd,
            upper=end,
            found_below=int(np.sum(inside)),
            symmetric_count=None,
            min_growth=-search.decay,
        )
        wanted = both[1] if left and both is not None else None
        return _damped_modes(problem, pairs, wanted, window)


def _left_vectors(
    problem: EigenProblem, factors: Shifted, pairs: QuadraticPairs, values: Complexes, x: Complexes
) -> LeftVectors:
    """Left vectors of damped eigenpairs."""
    matrices, damping = problem.matrices, Damping(problem.matrices)
    y = _dual(matrices, damping, pairs, values, x, problem.end)
    g = np.empty((0, y.shape[1]), dtype=complex)
    if matrices.multipliers is not None:
        y, g = inverse_step(
            matrices, damping, factors, pairs.eigenvalues, y.conj(), transposed=True
        )
        y, g = y.conj(), g.conj()
    damping.free()
    return LeftVectors(y, g)


def _dual(
    matrices: Matrices,
    damping: Damping,
    pairs: QuadraticPairs,
    left_values: Complexes,
    left_vectors: Complexes,
    end: float,
) -> Complexes:
    """Left vectors in the order of right ones, y^H (2 lambda M + D) x = 2 lambda.

    Without damping that is y^H M x = 1. Where eigenvalues touch, they are the dual basis of the
    right ones: y_i^H ((lambda_i + lambda_j) M + D) x_j vanishes for i and j that differ.

    Raises
    ------
    ConvergenceError
        When an eigenvalue has no left vector.
    """
    values, x, comm = pairs.eigenvalues, pairs.vectors, matrices.stiffness.comm
    scale = np.abs(values).max(initial=SLOW * end)  # rigid motions have no speed of their own
    rows, columns = assign(np.abs(values[:, None] - left_values) / scale, SAME)
    if len(rows) < len(values):
        raise ConvergenceError(
            f"{len(values) - len(rows)} of {len(values)} eigenvalues have no left vector",
            best=left_values,
        )
    left = left_vectors[:, columns].conj()
    for members in group(values, np.sqrt(DEGENERATE)):
        own = values[members]
        inertia = all_inner(left[:, members], times(matrices.mass, x[:, members]), comm)
        drag = all_inner(left[:, members], damping.times(x[:, members]), comm)
        overlap = (own[:, None] + own) * inertia + drag
        left[:, members] = left[:, members] @ np.linalg.pinv(overlap).conj().T * (2 * own.conj())
    return left


def _real(values: Complexes, uncertainties: Floats, near: float) -> NDArray[np.bool_]:
    """Which eigenvalues are real: next to the axis, where both of a conjugate pair were found.

    Their imaginary parts are rounding, or have no other of the opposite sign.
    """
    real = np.abs(values.imag) <= np.minimum(uncertainties, near)
    above = np.flatnonzero((values.imag > 0) & (values.imag <= near) & ~real)
    below = np.flatnonzero((values.imag < 0) & (values.imag >= -near) & ~real)
    distance = np.abs(values[above][:, None] - values[below].conj())
    size = np.maximum(values.imag[above][:, None], -values.imag[below])
    rows, columns = assign(distance / size, 1.0)
    real[np.delete(above, rows)] = True
    real[np.delete(below, columns)] = True
    return real


def _damped_modes(
    problem: EigenProblem,
    pairs: QuadraticPairs,
    left: LeftVectors | None,
    window: QuadraticWindow,
) -> Modes:
    """Modes in the window, those that decay faster than it reaches left out."""
    eigenvalues, slopes = pairs.eigenvalues, pairs.slopes
    uncertainties = pairs.uncertainties
    matrices, near = problem.matrices, MARGIN * problem.end
    real = _real(eigenvalues, uncertainties, near)
    eigenvalues = np.where(real, eigenvalues.real, eigenvalues)
    inside = (eigenvalues.imag >= 0) & (eigenvalues.imag <= window.upper)
    rigid = np.abs(eigenvalues) <= uncertainties
    inside &= (eigenvalues.real >= window.min_growth) | rigid
    bounded = np.zeros(len(eigenvalues), dtype=bool)
    if matrices.conservative:
        bounded = cannot_grow(-1j * eigenvalues, uncertainties, symmetric=False)
    order: Any = np.lexsort((eigenvalues.real, eigenvalues.imag))
    order = order[inside[order]]
    modes = Modes(
        eigenvalues=eigenvalues[order],
        residuals=pairs.residuals[order],
        conditions=np.maximum(2 * np.abs(eigenvalues) * slopes, 1.0)[order],
        growth_uncertainties=uncertainties[order],
        bounded=bounded[order],
        vectors=pairs.vectors[:, order],
        forces=pairs.forces[:, order],
        left=left[order] if left is not None else None,
        template=matrices.stiffness.createVecRight(),
        window=window,
        pencil=problem.pencil,
        values=problem.values,
    )
    refuse_what_is_lost(modes, eigenvalues, uncertainties)
    return replace(modes, warnings=warnings_of(modes))
