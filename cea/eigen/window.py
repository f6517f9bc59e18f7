"""Search of a window: discs about real shifts, and what shows that none of its modes is missing.

Without damping the first lies about the middle of the window, in kappa = -lambda^2. Where friction
leaves no more than a cone about the real axis it covers the window; else further discs, left of
all, cover it as far as friction may move eigenvalues (:mod:`cea.eigen.regions`). With damping or
rotation the window holds the lambda with 0 <= Im lambda <= omega and Re lambda >= -d, and a disc
about a real shift c > 0,

    abs(lambda - c)^2 <= (c + d)^2 + omega^2,

holds all of it up to the growth 2 c + d, and the conjugates; further discs follow to the right.
Of small systems the first disc tells all (:mod:`cea.eigen.subspace`).
"""

import sys
from abc import abstractmethod
from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise

import numpy as np

from cea.arrays import Complexes
from cea.eigen.corrected_tests import CorrectedTests
from cea.eigen.field_of_values import bounded_growth, field_of_values, largest_growth
from cea.eigen.krylov_schur import KrylovOptions
from cea.eigen.pencil import Matrices
from cea.eigen.regions import Disc, distance_of_cone, distance_within, touching_disc, upper_end
from cea.eigen.search import ATTEMPTS, SHIFT, Search
from cea.eigen.shift_invert import MARGIN
from cea.eigen.shifted import count_below
from cea.eigen.spectrum import Window
from cea.errors import ConvergenceError
from cea.timing import StageTimer

_DEPTH, _DEEP = 0.15, 3.0
"""Depth X of the first covering disc relative to omega^2: where friction reaches no farther, and
where it may, for modes that grow by 1.7 omega."""
_FARTHER = 8.0
"""Growth of the depth, or of a real shift, from one disc to the next."""
_REACHED = 0.8
"""Part of the depth of a disc that it answers for where eigenvalues may lie beyond."""
_AROUND = 1.5
"""Radius up to which a disc about the middle is searched, relative to that of the plain one."""
_DECAY = 0.1
"""Decay d down to which a damped window is complete by default, relative to omega."""
_LEAST_SHIFT, _FARTHEST_SHIFT = 0.1, 0.5
"""First real shift relative to omega: the least, so that it is no eigenvalue of those that hardly
grow, and the farthest, whose disc holds all that may grow."""
_CROWDED, _FEW = 4, 100
"""Eigenvalues in a disc that are too many: modes of the window without damping, and a number."""
_AWAY, _SLIM = 4.0, 2.0
"""Growth of a real shift where eigenvalues crowd, and the shift relative to omega from which on a
disc reaches little beyond the decay asked for."""


class WindowSearch(Search):
    """Searches of a window up to omega (1/s).

    Attributes
    ----------
    growth, bounded
        Every eigenvalue of the window that grows at this rate or slower was found (1/s), and
        whether none grows faster.
    """

    growth, bounded = 0.0, False

    def window(self, values: Complexes) -> Window:
        """What was searched, and why it is believed complete, given all eigenvalues found."""
        assert self.found is not None
        upper, symmetric_count, found_below = self._count(values)
        whole = self.found.whole
        disc = self.discs[0] if self.discs else Disc(0.0, 0.0)
        return Window(
            max_frequency=self._end / (2 * np.pi),
            shift=disc.centre,
            radius=disc.radius,
            found=len(values),
            discs=len(self.discs),
            max_growth=np.inf if whole or self.bounded else self.growth,
            bounded=whole or self.bounded,
            odd=symmetric_count is None and self.odd(),
            upper=upper,
            found_below=found_below,
            symmetric_count=symmetric_count,
            whole=whole,
            min_growth=-self.decay if self._matrices.quadratic else None,
        )

    @abstractmethod
    def _count(self, values: Complexes) -> tuple[float, int | None, int]:
        """An end, the eigenvalues below it by inertia if known, and those that were found."""


class UndampedSearch(WindowSearch):
    """Searches of a window of K x = kappa M x."""

    def __init__(
        self, matrices: Matrices, end: float, options: KrylovOptions, timer: StageTimer
    ) -> None:
        super().__init__(matrices, end, options, timer)
        self._top, self._upper = end**2, upper_end(end**2)
        self._counted: int | None = None

    def _count(self, values: Complexes) -> tuple[float, int | None, int]:
        return self._upper, self._counted, int(np.sum(values.real < self._upper))

    def _plan(self) -> Iterator[tuple[float, float]]:
        return self._symmetric() if self._matrices.symmetric else self._with_friction()

    def _symmetric(self) -> Iterator[tuple[float, float]]:
        """Discs until all that the inertia counts was found."""
        top, middle = self._top, 0.5 * self._top
        self.factorisations += 1
        with self.timer("factorisation"):
            counted = self._counted = count_below(self._matrices, self._upper)
        yield middle, self._upper - middle
        depth = 0.0
        while self._below() < counted and len(self.discs) <= self._options.max_discs:
            depth = _FARTHER * max(depth, top)  # a stiffness that is not positive definite
            centre = touching_disc(top, depth)
            yield centre, distance_within(top, centre, -depth, self._upper)
        self.growth, self.bounded = float(np.sqrt(depth)), self._below() == counted

    def _below(self) -> int:
        assert self.found is not None
        return int(np.sum(self.found.eigenvalues.real < self._upper))

    def _with_friction(self) -> Iterator[tuple[float, float]]:
        """Discs as far to the left as friction may move eigenvalues."""
        top, middle = self._top, 0.5 * self._top
        plain = self._upper - middle
        if self._matrices.size <= self._options.dense_limit:
            yield middle, plain
            return
        self.factorisations += 1
        with self.timer("factorisation"):
            slope = field_of_values(self._matrices, _DEPTH * top, cone=True)
        bounded = slope is not None
        depth, reached = (_DEPTH if bounded else _DEEP) * top, -top
        radius = np.inf if slope is None else distance_of_cone(top, middle, depth, slope)
        covers = radius <= _AROUND * plain
        yield middle, max(plain, radius) if covers else plain
        if covers and not self.odd():
            self.growth, self.bounded = float(np.sqrt(depth)), True
            return
        for _ in range(self._options.max_discs):
            centre, left = touching_disc(top, depth), depth if bounded else _REACHED * depth
            yield centre, distance_within(top, centre, -left, -reached)
            reached, depth = left, _FARTHER * depth
            bounded = bounded or self._bounds(reached)
            if bounded and not self.odd(self.discs[-1].centre):
                break
        self.growth, self.bounded = float(np.sqrt(max(reached, 0.0))), bounded
        for low, high in pairwise(sorted(self._parities)):  # a real one between two shifts
            if self.odd(low) != self.odd(high):
                yield 0.5 * (low + high), 0.5 * (high - low)

    def _bounds(self, depth: float) -> bool:
        """Whether nothing of the window has Re kappa < -depth: by as few tests as show it."""
        with self.timer("factorisation"):
            self.factorisations += 1
            if field_of_values(self._matrices, depth) is not None:
                return True
            try:
                self.factorisations += 1
                return self._corrected is not None and self._corrected.bounds(self._top, depth)
            except ConvergenceError:  # what shows nothing must not end what was found
                return False

    @cached_property
    def _corrected(self) -> CorrectedTests | None:
        return CorrectedTests.of(self._matrices)

    def free(self) -> None:
        """Free the factors and the test functions."""
        super().free()
        if (tests := vars(self).pop("_corrected", None)) is not None:
            tests.free()


class DampedSearch(WindowSearch):
    """Searches of a window of (lambda^2 M + lambda (C + Y) + K) x = 0.

    The decay d (1/s) may be lessened where modes crowd, unless it is asked for.
    """

    def __init__(
        self,
        matrices: Matrices,
        end: float,
        options: KrylovOptions,
        timer: StageTimer,
        decay: float | None,
    ) -> None:
        super().__init__(matrices, end, options, timer)
        self._asked = decay is not None
        self.decay = _DECAY * end if decay is None else decay

    def _count(self, values: Complexes) -> tuple[float, int | None, int]:
        return self._end, None, int(np.sum((values.imag >= 0) & (values.imag <= self._end)))

    def _radius(self, centre: float, left: float) -> float:
        """Radius of a disc that holds the window to the right of a real part."""
        return float(np.hypot(centre - left, (1 + MARGIN) * self._end))

    def _plan(self) -> Iterator[tuple[float, float]]:
        """Discs from the decay to the right, as far as modes may grow."""
        end = self._end
        with self.timer("factorisation"):
            self.factorisations += 2
            largest = largest_growth(self._matrices, end)
        centre = max(_LEAST_SHIFT * end, 0.5 * (largest - self.decay))
        yield from self._not_crowded(centre if centre <= _FARTHEST_SHIFT * end else SHIFT * end)
        assert self.found is not None
        centre = self.discs[0].centre
        self.growth = 2 * centre + self.decay
        while True:
            self.bounded = self.found.whole or self.growth >= largest
            if not self.bounded:
                self.factorisations += 1
                with self.timer("factorisation"):
                    self.bounded = bounded_growth(self._matrices, self.growth, end)
            if self.bounded and not self.odd(self.discs[-1].centre):
                break
            if len(self.discs) > self._options.max_discs:
                break
            left, centre = self.growth, _FARTHER * centre
            yield centre, self._radius(centre, left)
            self.growth = 2 * centre - left

    def _not_crowded(self, centre: float) -> Iterator[tuple[float, float]]:
        """The first disc, about shifts farther to the right until its modes do not crowd.

        Overdamped modes may crowd at one rate of decay. From farther to the right a disc reaches
        less beyond the decay asked for; where that does not help it is reduced, if nobody asked.
        """
        if self._matrices.size > self._options.dense_limit:  # else any number is affordable
            self.factorisations += 1
            with self.timer("factorisation"):
                counted = count_below(self._matrices, self._end**2)
            self._most = _CROWDED * counted + _FEW
        for _ in range(ATTEMPTS):
            yield centre, self._radius(centre, -self.decay)
            if not self._crowded:
                self._most = sys.maxsize
                return
            self._free_operator()
            if centre >= _SLIM * self._end and not self._asked:
                self.decay /= _AWAY
            centre *= _AWAY
        raise ConvergenceError(
            f"{self._crowded}: modes crowd near or above the growth rate {-self.decay:.4g} 1/s; "
            "a higher min_growth leaves them out"
        )
