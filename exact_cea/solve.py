"""Complete lists of eigenvalues of a characteristic function, with their correct digits."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Self

import numpy as np
from flint import acb, arb, ctx
from numpy.typing import NDArray

from cea.errors import ConvergenceError, InputError
from exact_cea.numbers import check_window
from exact_cea.roots import Box, EdgeTooClose, Root, RootFinder, polish

DIGITS = 25

Guess = Callable[[int], NDArray[np.complex128]]
"""Return that many of the lowest eigenvalues, approximated by another method."""


class Characteristic(ABC):
    """A problem whose eigenvalues are the roots of an entire function of ``lambda^2``."""

    @property
    @abstractmethod
    def real(self) -> bool:
        """Whether the function is real for real arguments."""

    @abstractmethod
    def scale(self) -> float:
        """Estimate of the lowest angular frequency."""

    @abstractmethod
    def turning(self, frequency: float) -> float:
        """Rate of change of the function's phase with lambda: the sum of travel times of waves."""

    def for_frequency(self, frequency: float) -> Self:
        """Return the problem with enough terms for eigenvalues up to a frequency."""
        return self

    def refined(self) -> Self:
        """Return the problem with more terms, or itself if more are not needed."""
        return self

    def closed_form(self, frequency: float) -> list[acb]:
        """Eigenvalues that are not roots of the function: modes without contact pressure."""
        return []

    @abstractmethod
    def __call__(self, kappa: acb) -> acb:
        """Characteristic function at ``kappa = lambda^2``."""


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues with Im >= 0 in a window, sorted by frequency."""

    roots: list[Root]  # roots of the characteristic function with their correct digits
    contact_free: list[acb]  # imaginary eigenvalues in closed form, without contact pressure
    box: Box  # the window, in which the list is complete by the argument principle

    @property
    def values(self) -> list[complex]:
        """Roots in double precision."""
        return [complex(root.value) for root in self.roots]


def spectrum(
    problem: Characteristic,
    max_frequency: float | None = None,
    count: int | None = None,
    max_growth: float | None = None,
    digits: int = DIGITS,
    guess: Guess | None = None,
) -> Spectrum:
    """Return all eigenvalues with Im lambda up to ``max_frequency``, or the lowest ``count``.

    The window is enlarged until it contains ``count``. ``max_growth`` bounds abs(Re lambda), by
    default by half of the frequency. If guesses converge to as many distinct roots as the window
    contains, the search is skipped; otherwise they are ignored.
    """
    check_window(max_frequency, count)
    if max_growth is not None and not 0 < max_growth < math.inf:
        raise InputError("max_growth", max_growth, "a positive number")
    if max_frequency is not None:
        frequency = max_frequency
    elif count is not None and guess is not None:
        frequency = 1.01 * float(guess(count)[-1].imag)
    else:
        frequency = 2 * problem.scale()
    while True:
        window = _Window.open(problem.for_frequency(frequency), frequency, max_growth)
        if count is None or window.size >= count:
            found = window.spectrum(digits, guess)
            if count is None:
                return found
            if len(found.roots) >= count:
                return _lowest(found, count)
        frequency *= 1.5 if guess is None else 1.15


def _lowest(found: Spectrum, count: int) -> Spectrum:
    last = float(found.roots[count - 1].value.imag)
    free = [value for value in found.contact_free if float(value.imag) <= last]
    return Spectrum(found.roots[:count], free, replace(found.box, top=last))


@dataclass(frozen=True)
class _Window:
    """A box whose edge is not near a root, and the number of roots in it."""

    problem: Characteristic
    finder: RootFinder
    box: Box
    frequency: float
    size: int

    @classmethod
    def open(cls, problem: Characteristic, frequency: float, max_growth: float | None) -> "_Window":
        """Count the roots; enlarge the box by up to 0.7 per cent if its edge is near one."""
        growth = max_growth or frequency / 2
        finder = RootFinder(problem, problem.turning(frequency), problem.real)
        for widening in (1.0, 1.0017, 1.0041, 1.0073):
            box = Box(-growth * widening, growth * widening, 0, frequency * widening)
            try:
                return cls(problem, finder, box, frequency, finder.count(box))
            except EdgeTooClose:
                continue
        raise ConvergenceError(f"roots lie too close to the edge of the window up to {frequency}")

    def spectrum(self, digits: int, guess: Guess | None) -> Spectrum:
        """Return all roots up to the frequency, refined by Newton's method and sorted."""
        with ctx.workdps(2 * digits):
            free = sorted(
                self.problem.closed_form(self.frequency), key=lambda value: float(value.imag)
            )
        roots = self._from_guess(guess, free, digits) if guess and self.size else None
        if roots is None:
            starts = self.finder.roots(self.box, self.size)
            roots = [_finish(self.problem, start, digits) for start in starts]
        kept = [root for root in roots if float(root.value.imag) <= self.frequency]
        kept.sort(key=lambda root: (float(root.value.imag), float(root.value.real)))
        return Spectrum(kept, free, replace(self.box, top=self.frequency))

    def _from_guess(self, guess: Guess, free: list[acb], digits: int) -> list[Root] | None:
        """Return the roots that guesses converge to, or None if these are not all roots."""
        known = [complex(value) for value in free]
        starts = [
            complex(value)
            for value in guess(self.size + len(free) + 2)
            if value in self.box and all(abs(value - z) > 1e-6 * abs(z) for z in known)
        ]
        if len(starts) != self.size:
            return None
        roots = [_finish(self.problem, start, digits) for start in starts]
        values = [complex(root.value) for root in roots]
        different = all(abs(y - z) > 1e-8 * abs(z) for y, z in combinations(values, 2))
        return roots if different and all(value in self.box for value in values) else None


def _finish(problem: Characteristic, start: complex, digits: int) -> Root:
    """Refine a root with more and more terms; set negligible real or imaginary parts to zero."""
    root = polish(problem, start, digits)
    while (refined := problem.refined()) is not problem:
        again = polish(refined, complex(root.value), digits)
        agreed = agreement(root.value, again.value, digits)
        problem, root = refined, Root(again.value, min(again.digits, agreed))
        if agreed >= digits:
            break
    real, imaginary = root.value.real, root.value.imag
    with ctx.workdps(2 * digits):
        # The mirror image of a root is a root; within the error of a simple root, they coincide.
        small = abs(root.value) * 10 ** acb(-min(root.digits, digits) + 2).real
        if problem.real and abs(real) < small:
            return Root(acb(0, imaginary), root.digits)
        if problem.real and abs(imaginary) < small:
            return Root(acb(abs(real), 0), root.digits)
    return root


def agreement(x: acb, y: acb, digits: int) -> int:
    """Number of digits that two numbers share."""
    with ctx.workdps(2 * digits):
        apart = abs(x - y) / abs(y)
        if apart.abs_upper() < arb(10) ** (-2 * digits):
            return 2 * digits
        return math.floor(-float(apart.abs_upper().log()) / math.log(10))
