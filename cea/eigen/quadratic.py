"""The driver of (lambda^2 M + lambda (C + Y) + K) x = 0: damped and rotating pencils.

:class:`cea.eigen.krylov_schur.KrylovSchur` hands it what is not linear in lambda^2.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.linalg import LinAlgError
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import all_inner, times
from cea.eigen.classify import cannot_grow
from cea.eigen.eigenvalue_matching import DEGENERATE, assign, group
from cea.eigen.modes import Modes, refuse_what_is_lost, warnings_of
from cea.eigen.pencil import Matrices, Pencil
from cea.eigen.quadratic_damping import Damping
from cea.eigen.quadratic_nearest import nearest_subspace, neighbours
from cea.eigen.quadratic_pairs import QuadraticPairs, checked_pairs, inverse_step
from cea.eigen.quadratic_search import MARGIN, QuadraticSearch, upper_half
from cea.eigen.quadratic_two_sided import judged_by_both, one_sided
from cea.eigen.quadratic_window import QuadraticFound, QuadraticWindow
from cea.eigen.sensitivity import SAME, LeftVectors, dual_norms
from cea.eigen.spectrum import SLOW
from cea.eigen.subspace import InvariantSubspace
from cea.errors import ConvergenceError
from cea.timing import StageTimer


@dataclass
class QuadraticDriver:
    """Solves one quadratic pencil at given parameters.

    Parameters
    ----------
    pencil, values
        What is solved, and at which parameters.
    matrices
        The pencil there.
    tolerance, max_restarts
        Of each search (:class:`cea.eigen.block_krylov.BlockSearch`).
    timer
        Counts factorisation, krylov and post-processing.

    Attributes
    ----------
    factorisations
        Factorisations made so far.
    """

    pencil: Pencil
    values: Mapping[str, float]
    matrices: Matrices
    tolerance: float
    max_restarts: int
    timer: StageTimer
    factorisations: int = 0

    def solve(self, max_frequency: float, min_growth: float | None, *, left: bool) -> Modes:
        """All modes up to a frequency, of any growth, and down to a decay.

        Parameters
        ----------
        max_frequency
            Upper end of the modes asked for (Hz).
        min_growth
            Growth rate (1/s), zero or less, down to which they are asked for; None takes a tenth
            of the angular frequency of the end, or less where overdamped modes crowd.
        left
            Whether left vectors are wanted too.

        Raises
        ------
        ConvergenceError
            When the window cannot be filled; the modes found so far are attached.
        """
        end = 2 * np.pi * max_frequency
        search = QuadraticSearch(
            self.matrices,
            end,
            None if min_growth is None else -min_growth,
            tolerance=self.tolerance,
            max_restarts=self.max_restarts,
            timer=self.timer,
        )
        try:
            found = search.window()
            return self._judged(search, found, end, left=left)
        except ConvergenceError as error:
            if isinstance(error.best, InvariantSubspace) and search.factors is not None:
                known = QuadraticFound(error.best)
                error.best = self._judged(search, known, end, left=None)
            raise
        finally:
            self.factorisations += search.factorisations
            search.free()

    def _judged(
        self,
        search: QuadraticSearch,
        found: QuadraticFound,
        end: float,
        *,
        left: bool | None,
    ) -> Modes:
        """Modes of what was found; None for ``left`` searches no left vectors whatever is found."""
        assert search.factors is not None
        with self.timer("post-processing"):
            subspace = upper_half(found.subspace, end)
            pairs = checked_pairs(self.matrices, search.factors, subspace, end)
        pairs, vectors = self._by_left(search, subspace, pairs, end, left=left)
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
        near = MARGIN * end
        return _modes_of(self.pencil, self.values, self.matrices, pairs, vectors, window, near)

    def nearest(self, place: complex, wanted: int) -> Modes:
        """The few modes nearest to lambda = place.

        Parameters
        ----------
        place
            lambda (1/s), Im lambda >= 0; not zero.
        wanted
            Number of eigenvalues with Im lambda >= 0; a few more may come.

        Raises
        ------
        ConvergenceError
            When fewer converge.
        """
        self.factorisations += 1
        found, factors = nearest_subspace(
            self.matrices,
            place,
            wanted,
            tolerance=self.tolerance,
            max_restarts=self.max_restarts,
            timer=self.timer,
        )
        with self.timer("post-processing"):
            pairs = checked_pairs(self.matrices, factors, found, abs(place))
        factors.free()
        window, near = neighbours(place, found), MARGIN * abs(place)
        return _modes_of(self.pencil, self.values, self.matrices, pairs, None, window, near)

    def _by_left(
        self,
        search: QuadraticSearch,
        subspace: InvariantSubspace,
        pairs: QuadraticPairs,
        end: float,
        *,
        left: bool | None,
    ) -> tuple[QuadraticPairs, LeftVectors | None]:
        """Eigenpairs judged by left vectors where right ones say too little, and left vectors."""
        assert search.factors is not None
        unsure, found = False, None
        if left is not None:
            with self.timer("post-processing"):
                unsure = one_sided(self.matrices, search.factors, subspace, pairs, end)
        if left or unsure:
            try:
                found = self._left(search, pairs, end)
            except (ConvergenceError, LinAlgError):
                if left:
                    raise
        with self.timer("post-processing"):
            if left and found is not None:
                slopes = dual_norms(self.matrices.mass, found[1].vectors)
                with np.errstate(divide="ignore", invalid="ignore"):
                    slopes = slopes / (2 * np.abs(pairs.eigenvalues))
                slopes = np.where(np.isfinite(slopes), slopes, pairs.slopes)
                pairs = replace(pairs, slopes=slopes)
            if unsure:
                pairs = judged_by_both(self.matrices, subspace, pairs, found, end)
        return pairs, found[1] if left and found is not None else None

    def _left(
        self, search: QuadraticSearch, pairs: QuadraticPairs, end: float
    ) -> tuple[Complexes, LeftVectors]:
        """Eigenvalues of the transposed pencil, and left vectors of the eigenpairs found."""
        values, vectors = search.left()
        assert search.factors is not None
        with self.timer("post-processing"):
            damping = Damping(self.matrices)
            y = _dual(self.matrices, damping, pairs, values, vectors, end)
            g = np.empty((0, y.shape[1]), dtype=complex)
            if self.matrices.multipliers is not None:
                y, g = inverse_step(
                    self.matrices,
                    damping,
                    search.factors,
                    pairs.eigenvalues,
                    y.conj(),
                    transposed=True,
                )
                y, g = y.conj(), g.conj()
            damping.free()
        return values, LeftVectors(y, g)


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
        left[:, members] = left[:, members] @ np.linalg.inv(overlap).conj().T * (2 * own.conj())
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


def _modes_of(
    pencil: Pencil,
    values: Mapping[str, float],
    matrices: Matrices,
    pairs: QuadraticPairs,
    left: LeftVectors | None,
    window: QuadraticWindow,
    near: float,
) -> Modes:
    """Modes in the window, those that decay faster than it reaches left out."""
    eigenvalues, slopes = pairs.eigenvalues, pairs.slopes
    uncertainties = pairs.uncertainties
    real = _real(eigenvalues, uncertainties, near)
    eigenvalues = np.where(real, eigenvalues.real, eigenvalues)
    inside = (eigenvalues.imag >= 0) & (eigenvalues.imag <= window.upper)
    inside &= eigenvalues.real >= window.min_growth
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
        pencil=pencil,
        values=values,
    )
    refuse_what_is_lost(modes, eigenvalues, uncertainties)
    return replace(modes, warnings=warnings_of(modes))
