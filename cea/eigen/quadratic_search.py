"""Search of a window of a damped or rotating pencil, and what shows that nothing is missing.

The window holds the lambda with 0 <= Im lambda <= omega and Re lambda >= -d: of any growth, and
down to a decay d. A disc about a real shift c > 0,

    abs(lambda - c)^2 <= (c + d)^2 + omega^2,

holds all of it up to the growth 2 c + d, and the conjugates: matrices, factors and vectors are
real. It is searched until nothing more comes beside what was found. Where eigenvalues may grow
faster (:mod:`cea.eigen.quadratic_coverage`), further discs follow to the right.
"""

import sys

import numpy as np
from scipy.linalg import schur

from cea.arrays import Complexes
from cea.eigen.companion import CompanionSearch
from cea.eigen.dense_products import combined
from cea.eigen.krylov_run import CrowdedError
from cea.eigen.pencil import Matrices
from cea.eigen.quadratic_coverage import bounded_growth, first_shift, largest_growth
from cea.eigen.quadratic_shifted import QuadraticShifted
from cea.eigen.quadratic_window import QuadraticFound, ShiftedDisc
from cea.eigen.sensitivity import SAME
from cea.eigen.shifted import count_below
from cea.eigen.subspace import InvariantSubspace
from cea.errors import ConvergenceError
from cea.timing import StageTimer

MARGIN = 0.005
"""What is covered beyond both ends of the window relative to omega: room between the window and the
first mode beyond it, and conjugates of those next to the real axis."""
_SIGN = 0.01
"""Real shift relative to omega beyond which real eigenvalues are even or odd in number."""
_DECAY = 0.1
"""Decay d down to which a window is complete by default, relative to omega."""
_CROWD = 1000
"""Unknowns up to which a disc may hold any number of eigenvalues."""
_CROWDED, _FEW = 4, 100
"""Eigenvalues in a disc that are too many: modes of the window without damping, and a number."""
_ATTEMPTS, _AWAY = 6, 4.0
"""Shifts tried where eigenvalues crowd, and growth of the shift from one to the next."""
_SLIM = 2.0
"""Shift relative to omega from which on a disc reaches little beyond the decay asked for."""
_FARTHER = 8.0
"""Growth of the shift from one disc to the next."""
_SMALL = 10_000
"""Unknowns up to which further discs are cheap."""
_MOST_DISCS = {True: 24, False: 3}
"""Most further discs of small systems, and of others."""
_MOST_SEARCHES = 20
"""Searches of one disc, each beside what those before it found."""
_ASIDE = 1e-3
"""Step of a shift aside relative to itself, from an eigenvalue that is the square as near."""
_STEPS_ASIDE = 4
"""Most such steps."""
_INSIDE = 1 + SAME
"""Radius of a disc of left eigenvalues relative to the farthest right one in it: those that are the
same but for rounding, which is large of rigid motions and near coalescence, are inside."""


class QuadraticSearch:
    """Searches of one window of one pencil at given parameters.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    end
        omega (1/s).
    decay
        d (1/s); None takes a tenth of omega, or less where modes crowd.
    tolerance, max_restarts
        Of each search (:class:`cea.eigen.block_krylov.BlockSearch`).
    timer
        Counts factorisation and krylov.

    Attributes
    ----------
    factors
        The pencil factorised at the first shift, once it was searched.
    factorisations
        Factorisations made so far.
    decay
        d (1/s), once the window was searched.
    """

    def __init__(
        self,
        matrices: Matrices,
        end: float,
        decay: float | None,
        *,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
    ) -> None:
        self._matrices, self._end = matrices, end
        self._asked = decay is not None
        self.decay = _DECAY * end if decay is None else decay
        self._limits = tolerance, max_restarts
        self._timer = timer
        self.factorisations = 0
        self.factors: QuadraticShifted | None = None
        self._searches = 0
        self._discs: list[ShiftedDisc] = []
        self._most = sys.maxsize
        self._farthest: dict[float, float] = {}
        self._farthest_lambda = np.inf

    def window(self) -> QuadraticFound:
        """Every eigenvalue of the window, with what shows it.

        Raises
        ------
        ConvergenceError
            When a disc does not become full; ``best`` is what was found.
        """
        left, most = -self.decay, _MOST_DISCS[self._matrices.size <= _SMALL]
        self.factorisations += 2
        with self._timer("factorisation"):
            largest = largest_growth(self._matrices, self._end)
        if self._matrices.size > _CROWD:
            with self._timer("factorisation"):
                modes = count_below(self._matrices, self._end**2)
            self._most = _CROWDED * modes + _FEW
        known, centre = self._not_crowded(first_shift(largest, left, self._end))
        left = -self.decay
        growth = 2 * centre - left
        bounded = growth >= largest or self._bounded(growth)
        while not bounded and known.size < self._finite and len(self._discs) <= most:
            left, centre = growth, _FARTHER * centre
            try:
                known = self._beside(known, centre, self._radius(centre, left))
            except CrowdedError:
                break
            growth = 2 * centre - left
            bounded = growth >= largest or self._bounded(growth)
        if known.size >= self._finite:
            growth, bounded = np.inf, True
        odd = self._odd(known)
        if odd and np.isfinite(growth):
            known = self._beside(known, 0.5 * growth, 0.5 * growth)
            odd = self._odd(known)
        return QuadraticFound(known, tuple(self._discs), growth, bounded, odd)

    @property
    def _finite(self) -> int:
        return 2 * (self._matrices.size - self._matrices.tied)

    def _radius(self, centre: float, left: float) -> float:
        """Radius of a disc that holds the window to the right of a real part."""
        return float(np.hypot(centre - left, (1 + MARGIN) * self._end))

    def _not_crowded(self, centre: float) -> tuple[InvariantSubspace, float]:
        """Eigenvalues of the first disc, and the real part of its shift.

        Overdamped modes may crowd at one rate of decay. From farther to the right a disc reaches
        less beyond the decay asked for; where that does not help it is reduced, if nobody asked.
        """
        for _ in range(_ATTEMPTS):
            try:
                return self._first(centre, -self.decay), centre
            except CrowdedError as error:
                crowded = error
            self.free()
            self._farthest.clear()
            if centre >= _SLIM * self._end and not self._asked:
                self.decay /= _AWAY
            centre *= _AWAY
        raise ConvergenceError(
            f"{crowded}: modes crowd near or above the growth rate {-self.decay:.4g} 1/s; a higher "
            "min_growth leaves them out"
        )

    def _first(self, centre: float, left: float) -> InvariantSubspace:
        """Eigenvalues of the first disc, whose shift steps aside where it is one."""
        shift, radius = centre, self._radius(centre, left)
        for _ in range(_STEPS_ASIDE):
            self.factors = self._factorised(shift)
            if self.factors is not None:
                known = self._filled(self._nothing(), self.factors, radius)
                nearest = np.abs(known.eigenvalues() - shift).min(initial=np.inf)
                if nearest > _ASIDE**2 * abs(shift):
                    return known
                self.factors.free()
            self._farthest.clear()
            self._discs.clear()
            radius += _ASIDE * abs(shift)
            shift *= 1 + _ASIDE
        self.factors = None
        raise ConvergenceError(f"the pencil is singular at every shift near {shift:.4g} 1/s")

    def _factorised(self, shift: float) -> QuadraticShifted | None:
        """Factors at a shift; None where it is an eigenvalue."""
        self.factorisations += 1
        with self._timer("factorisation"):
            try:
                return QuadraticShifted(self._matrices, shift)
            except ConvergenceError:
                return None

    def _beside(self, known: InvariantSubspace, shift: float, radius: float) -> InvariantSubspace:
        """The known with what lies in another disc."""
        factors = self._factorised(shift)
        if factors is None:
            raise ConvergenceError(f"lambda = {shift:.6g} is an eigenvalue", best=known)
        known = self._filled(known, factors, radius)
        factors.free()
        return known

    def _filled(
        self,
        known: InvariantSubspace,
        factors: QuadraticShifted,
        radius: float,
        *,
        transposed: bool = False,
    ) -> InvariantSubspace:
        """Search a disc again and again beside what was found, until nothing more is."""
        tolerance, max_restarts = self._limits
        krylov = CompanionSearch(
            self._matrices,
            factors,
            self._end,
            tolerance=tolerance,
            max_restarts=max_restarts,
            timer=self._timer,
            most=self._most,
            transposed=transposed,
        )
        centre = float(factors.shift.real)
        for _ in range(_MOST_SEARCHES):
            before = known.size
            known = krylov.search(known, radius, self._searches, both_ends=True)
            self._farthest_lambda = krylov.farthest
            self._searches += 1  # never from the same random vectors
            new = np.abs(known.eigenvalues(before) - centre)
            if not transposed and len(new):
                farthest = max(self._farthest.get(centre, 0.0), float(new.max()))
                self._farthest[centre] = farthest
            if not (new < radius).any():
                break
        else:
            raise ConvergenceError(
                f"the disc of radius {radius:.4g} about lambda = {centre:.4g} is not full after "
                f"{_MOST_SEARCHES} searches, each of which found more",
                best=known,
            )
        krylov.free()
        if not transposed:
            self._discs.append(ShiftedDisc(centre, radius))
        return known

    def left(self) -> tuple[Complexes, Complexes]:
        """All eigenvalues that were found, and conjugates of their left vectors, the rows of x."""
        known = self._nothing()
        for centre, distance in self._farthest.items():
            factors = self.factors
            if factors is None or factors.shift != centre:
                factors = self._factorised(centre)
            assert factors is not None
            known = self._filled(known, factors, _INSIDE * distance, transposed=True)
            if factors is not self.factors:
                factors.free()
        values, vectors = known.eigenpairs()
        return values, vectors[: len(vectors) // 2]

    def free(self) -> None:
        """Free the factors."""
        if self.factors is not None:
            self.factors.free()

    def _odd(self, known: InvariantSubspace) -> bool:
        """Whether the sign of a determinant shows that a real eigenvalue is missing.

        Of those next to the real axis conjugates were found too: they count twice, or not.
        """
        factors = self._factorised(_SIGN * self._end)
        if factors is None:
            return False
        parity = factors.parity()
        factors.free()
        values = known.eigenvalues()
        real = np.abs(values.imag) <= MARGIN * self._end
        return parity not in (None, int((real & (values.real > _SIGN * self._end)).sum()) % 2)

    def _bounded(self, growth: float) -> bool:
        """Whether no eigenvalue of the window grows at a rate or faster."""
        if self._farthest_lambda <= growth:
            return True
        self.factorisations += 1
        with self._timer("factorisation"):
            return bounded_growth(self._matrices, growth, self._end)

    def _nothing(self) -> InvariantSubspace:
        rows = 2 * self._matrices.stiffness.getLocalSize()[0]
        return InvariantSubspace.empty(rows, symmetric=False)


def upper_half(found: InvariantSubspace, end: float) -> InvariantSubspace:
    """Without the eigenvalues below the real axis that are not next to it, beside omega (1/s)."""
    if not found.size:
        return found
    form, vectors, kept = schur(
        found.projected, output="complex", sort=lambda value: bool(value.imag >= -MARGIN * end)
    )
    return InvariantSubspace(combined(found.basis, vectors[:, :kept]), form[:kept, :kept], False)
