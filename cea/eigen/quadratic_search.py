"""Search of a window of a damped or rotating pencil, and what shows that nothing is missing.

The window holds the lambda with 0 <= Im lambda <= omega and Re lambda >= -d: of any growth, and
down to a decay d. A disc about a real shift s,

    (Re lambda - s)^2 + (Im lambda)^2 <= (s + d)^2 + omega^2,

holds all of it up to the growth 2 s + d, and conjugates together. It is searched until nothing more
comes beside what was found. Where eigenvalues may grow faster, further discs follow to the right.
"""

from dataclasses import dataclass

import numpy as np

from cea.body import Complexes
from cea.eigen.companion import CompanionSearch
from cea.eigen.pencil import Matrices
from cea.eigen.quadratic_coverage import bounded_growth
from cea.eigen.quadratic_shifted import QuadraticShifted
from cea.eigen.subspace import InvariantSubspace
from cea.errors import ConvergenceError
from cea.timing import StageTimer

_SHIFT = 1.5
"""First shift relative to omega."""
_END = 1.005
"""End of what is covered relative to omega: room between the window and the first mode beyond."""
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
_INSIDE = 1 + 1e-9
"""Radius of a disc of left eigenvalues relative to the farthest right one in it."""


@dataclass(frozen=True)
class RealDisc:
    """A disc of lambda about a real shift in which every eigenvalue was found.

    Parameters
    ----------
    centre, radius
        In 1/s.
    """

    centre: float
    radius: float


@dataclass(frozen=True)
class QuadraticFound:
    """What a search of a window found.

    Parameters
    ----------
    subspace
        Invariant subspace of the eigenvalues found, of the companion form.
    discs
        Discs that are full.
    growth
        Every eigenvalue of the window with Re lambda <= growth was found (1/s).
    bounded
        Whether none grows faster.
    odd
        Whether the sign of a determinant shows that a real eigenvalue is missing.
    """

    subspace: InvariantSubspace
    discs: tuple[RealDisc, ...] = ()
    growth: float = 0.0
    bounded: bool = False
    odd: bool = False


class QuadraticSearch:
    """Searches of one window of one pencil at given parameters.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    end
        omega (1/s).
    decay
        d (1/s).
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
    """

    def __init__(
        self,
        matrices: Matrices,
        end: float,
        decay: float,
        *,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
    ) -> None:
        self._matrices, self._end, self._decay = matrices, end, decay
        self._limits = tolerance, max_restarts
        self._timer = timer
        self.factorisations = 0
        self.factors: QuadraticShifted | None = None
        self._searches = 0
        self._discs: list[RealDisc] = []
        self._farthest: dict[float, float] = {}
        self._signs: dict[float, int] = {}

    def window(self) -> QuadraticFound:
        """Every eigenvalue of the window, with what shows it.

        Raises
        ------
        ConvergenceError
            When a disc does not become full; ``best`` is what was found.
        """
        height = _END * self._end
        centre, left = _SHIFT * self._end, -self._decay
        known, centre = self._first(centre, np.hypot(centre - left, height))
        growth = 2 * centre - left
        bounded = self._bounded(growth)
        most = _MOST_DISCS[self._matrices.size <= _SMALL]
        while not bounded and known.size < self._finite and len(self._discs) <= most:
            left, centre = growth, _FARTHER * centre
            known = self._beside(known, centre, np.hypot(centre - left, height))
            growth = 2 * centre - left
            bounded = self._bounded(growth)
        if known.size >= self._finite:
            growth, bounded = np.inf, True
        return QuadraticFound(known, tuple(self._discs), growth, bounded, self._odd(known))

    @property
    def _finite(self) -> int:
        return 2 * (self._matrices.size - self._matrices.tied)

    def _first(self, centre: float, radius: float) -> tuple[InvariantSubspace, float]:
        """Eigenvalues about the first shift, which steps aside where it is one."""
        for _ in range(_STEPS_ASIDE):
            self.factors = self._factorised(centre)
            if self.factors is not None:
                known = self._filled(self._nothing(), self.factors, radius)
                nearest = np.abs(known.eigenvalues() - centre).min(initial=np.inf)
                if nearest > _ASIDE**2 * centre:
                    return known, centre
                self.factors.free()
            self._forget()
            radius += _ASIDE * centre
            centre *= 1 + _ASIDE
        self.factors = None
        raise ConvergenceError(f"the pencil is singular at every shift near {centre:.4g} 1/s")

    def _forget(self) -> None:
        for each in (self._farthest, self._signs, self._discs):
            each.clear()

    def _factorised(self, centre: float) -> QuadraticShifted | None:
        """Factors at a real shift; None where it is an eigenvalue."""
        self.factorisations += 1
        with self._timer("factorisation"):
            try:
                factors = QuadraticShifted(self._matrices, centre)
            except ConvergenceError:
                return None
        if (parity := factors.parity()) is not None:
            self._signs[centre] = parity
        return factors

    def _beside(self, known: InvariantSubspace, centre: float, radius: float) -> InvariantSubspace:
        """The known with what lies in another disc."""
        factors = self._factorised(centre)
        if factors is None:
            raise ConvergenceError(f"lambda = {centre:.6g} is an eigenvalue", best=known)
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
            transposed=transposed,
        )
        centre = krylov.shift
        for _ in range(_MOST_SEARCHES):
            before = known.size
            known = krylov.search(known, radius, self._searches, both_ends=True)
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
            self._discs.append(RealDisc(centre, radius))
        return known

    def left(self) -> tuple[Complexes, Complexes]:
        """Conjugates of all eigenvalues that were found, and their left vectors, the rows of x."""
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
        """Whether the sign of a determinant shows another real eigenvalue beyond its shift."""
        values = known.eigenvalues()
        real = values.real[values.imag == 0]
        return any(parity != int((real > s).sum()) % 2 for s, parity in self._signs.items())

    def _bounded(self, growth: float) -> bool:
        self.factorisations += 1
        with self._timer("factorisation"):
            return bounded_growth(self._matrices, growth, self._end)

    def _nothing(self) -> InvariantSubspace:
        rows = 2 * self._matrices.stiffness.getLocalSize()[0]
        return InvariantSubspace.empty(rows, symmetric=False)
