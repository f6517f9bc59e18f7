"""Thresholds along a parameter: every change of the number of growing modes is explained.

Eigenvalues between given values are interpolated (:mod:`cea.reduced.following`). Thresholds are
roots of functions that are positive where modes grow; they are found on the interpolant and refined
by Newton's method on the pencil itself. An interval is accepted if its roots explain the difference
of the numbers of growing modes at its ends, and if the signs of all interpolants are certain
elsewhere; otherwise it is halved. Intervals that remain are reported as unresolved.

Growing modes are counted in both half planes, so that the count does not change where a pair
becomes two real eigenvalues.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cea.reduced.crossings import NEAR, REAL, Crossings, Threshold
from cea.reduced.following import Sample, UnresolvedError, units_of
from cea.reduced.spectrum import Window

RESOLUTION = 1e-7
"""Width of an interval relative to the axis below which it is not halved further."""
BUDGET = 30
"""Largest number of spectra for each given value."""
_ASIDE = 1e-3
"""Largest step by which a value with undecided signs is moved, relative to the distance of the next
value, or to its interval."""
_MOVES = (0.0, 1 / 4096, 1 / 64, 1.0)
"""Fractions of that step, tried in turn."""


@dataclass(frozen=True)
class Line:
    """Spectra along one parameter: the window, and a function that returns the spectrum."""

    window: Window
    at: Callable[[float], Sample]


@dataclass(frozen=True)
class Unresolved:
    """An interval that may contain thresholds that were not found.

    ``before`` and ``after`` are the numbers of growing modes at its ends, of both half planes;
    ``eigenvalue`` is the lambda of least growth rate that grows at either end, None without any.
    """

    low: float
    high: float
    before: int
    after: int
    eigenvalue: complex | None


@dataclass
class Found:
    """Thresholds along a line, sorted by value, and unresolved intervals.

    ``resolution`` is the width of the widest interval that was accepted by the numbers of growing
    modes at its ends alone, zero without any; ``spectra`` is the number of spectra computed.
    """

    thresholds: list[Threshold] = field(default_factory=list)
    unresolved: list[Unresolved] = field(default_factory=list)
    resolution: float = 0.0
    spectra: int = 0


def _joined(unresolved: Sequence[Unresolved]) -> list[Unresolved]:
    """Return the intervals sorted by value, with adjacent ones joined."""
    joined: list[Unresolved] = []
    for each in sorted(unresolved, key=lambda each: each.low):
        if joined and joined[-1].high == each.low:
            last = joined.pop()
            either = last.eigenvalue if last.eigenvalue is not None else each.eigenvalue
            each = Unresolved(last.low, each.high, last.before, each.after, either)
        joined.append(each)
    return joined


def thresholds_along(line: Line, values: Sequence[float], *, logarithmic: bool = False) -> Found:
    """Return all thresholds between the least and the largest of two or more values.

    Intervals are halved, with ``logarithmic`` those of the logarithms of values.
    """
    return _Search(line, sorted(values), logarithmic=logarithmic).run()


class _Search:
    """One search, with the spectra it has computed."""

    def __init__(self, line: Line, values: list[float], *, logarithmic: bool) -> None:
        self._line, self._window, self._values = line, line.window, values
        self._logarithmic = logarithmic
        self._known: dict[float, Sample] = {}
        self._least = RESOLUTION * self._width(values[0], values[-1])
        self._found = Found()

    def run(self) -> Found:
        """Accept or halve intervals, the widest first; return the result."""
        queue: list[tuple[float, ...]] = []

        def push(places: Sequence[float]) -> None:
            heappush(queue, (-self._width(places[0], places[-1]), *places))

        ends = self._ends()
        for i in range(0, len(ends) - 1, 2):
            push(ends[i : i + 3])
        while queue:
            _, low, *inner, high = heappop(queue)
            if len(self._known) >= BUDGET * len(self._values):
                self._found.unresolved.append(self._unresolved(low, high))
                continue
            middle = inner[0] if inner else self._middle(low, high)
            try:
                self._found.thresholds += self._explained(low, middle, high)
            except UnresolvedError as why:
                if self._width(low, high) <= self._least:
                    self._accept_by_count(low, high)
                else:
                    for part in pairwise(self._cuts(low, middle, high, why.at)):
                        push(part)
        self._found.thresholds.sort(key=lambda each: each.value)
        if self._adds_up():
            self._found.unresolved = _joined(self._found.unresolved)
        else:
            self._found.unresolved = [self._unresolved(self._values[0], self._values[-1])]
        self._found.spectra = len(self._known)
        return self._found

    def _width(self, low: float, high: float) -> float:
        return float(np.log(high / low)) if self._logarithmic else high - low

    def _middle(self, low: float, high: float) -> float:
        return float(np.sqrt(low * high)) if self._logarithmic else (low + high) / 2

    def _adds_up(self) -> bool:
        """Whether the result explains the numbers of growing modes at both ends of the axis.

        It may not: growth that is zero within its error up to a coalescence has no root.
        """
        change = sum(each.change for each in self._found.thresholds)
        change += sum(each.after - each.before for each in self._found.unresolved)
        return change == self._number(self._values[-1]) - self._number(self._values[0])

    def _at(self, value: float) -> Sample:
        if value not in self._known:
            sample = self._line.at(value)
            self._known[value] = sample.with_mirror_image() if self._window.damped else sample
        return self._known[value]

    def _growing(self, value: float) -> NDArray[np.bool_]:
        """Return which eigenvalues of the window grow by more than their error."""
        sample, window = self._at(value), self._window
        z, errors = sample.z, sample.errors
        if window.by_growth:
            grows = window.growth(z) > window.doubts(z, errors)
        else:
            grows = np.where(z.imag != 0, np.abs(z.imag) > errors, z.real < -errors)
        growing: NDArray[np.bool_] = grows & ~window.far(z, 1.0)
        return growing

    def _number(self, value: float) -> int:
        """Return the number of growing eigenvalues of both half planes (one per kappa)."""
        return int(self._growing(value).sum())

    def _undecided(self, value: float) -> bool:
        """Whether a function whose zeros are thresholds vanishes within its error at a value."""
        sample, window = self._at(value), self._window
        z, inside = sample.z, ~window.far(sample.z, 1.0)
        if window.by_growth:
            doubts = window.doubts(z, sample.errors)
            return bool((np.abs(window.growth(z)) <= 2 * doubts)[inside].any())
        if (np.abs(z) <= sample.errors)[z.imag == 0].any():
            return True
        errors = np.maximum(sample.errors[:, None], sample.errors)
        near = np.abs(z[:, None] - z) <= 4 * errors
        np.fill_diagonal(near, False)
        return bool(near[np.ix_(inside, inside)].any())

    def _decided_near(self, value: float, step: float) -> float:
        """Return a nearby value at which no sign is undecided, or the last that was tried."""
        places = [value + part * step for part in _MOVES]
        return next((each for each in places if not self._undecided(each)), places[-1])

    def _ends(self) -> list[float]:
        """Return the given values, those with undecided signs moved slightly inwards."""
        values = self._values
        steps = [*np.diff(values).tolist(), values[-2] - values[-1]]
        pairs = zip(values, steps, strict=True)
        ends = [self._decided_near(value, _ASIDE * step) for value, step in pairs]
        for number in (0, -1):
            if ends[number] != values[number]:
                self._at_the_end(values[number], ends[number])
        return ends

    def _at_the_end(self, value: float, moved: float) -> None:
        """Add thresholds at an end of the axis for modes that grow beside it but not at it."""
        error, window = moved - value, self._window
        more = self._number(moved) - self._number(value)
        z = self._at(moved).z[self._growing(moved)]
        z = z[np.argsort(window.growth(z))]
        for each in z[z.imag >= 0 if window.damped else z.imag <= 0]:
            if more <= 0:
                return
            root = complex(window.roots(each[None])[0])
            real = abs(root.imag) <= REAL * window.end
            slope = float(window.growth(each[None])[0]) if window.by_growth else each.imag**2
            change, kind = (1, "divergence") if real else (2, "flutter")
            self._found.thresholds.append(
                Threshold(
                    value=value,
                    error=abs(error),
                    eigenvalue=complex(0.0, abs(root.imag)),
                    slope=0.0 if real else float(slope / error),
                    change=change if error > 0 else -change,
                    kind=kind,
                )
            )
            more -= change

    def _cuts(self, low: float, middle: float, high: float, at: float | None) -> list[float]:
        """Return the points at which an interval is cut: its ends, its middle sample and ``at``."""
        width, cuts = high - low, [middle]
        if at is not None and low + NEAR * width < at < high - NEAR * width:
            cuts = [at] if abs(at - middle) <= NEAR * width else [middle, at]
        inner = {self._decided_near(each, _ASIDE * width) for each in cuts}
        return sorted({low, high} | inner)

    def _unresolved(self, low: float, high: float) -> Unresolved:
        before, after = self._number(low), self._number(high)
        growing = [self._at(each).z[self._growing(each)] for each in (low, high)]
        roots = self._window.roots(np.concatenate(growing))
        least = complex(roots[np.argmin(roots.real)]) if len(roots) else None
        return Unresolved(low, high, before, after, least)

    def _accept_by_count(self, low: float, high: float) -> None:
        """Accept a narrow interval, as a threshold where the numbers at its ends differ."""
        interval = self._unresolved(low, high)
        if self._undecided(low) or self._undecided(high):
            self._found.unresolved.append(interval)
            return
        self._found.resolution = max(self._found.resolution, high - low)
        if interval.after != interval.before:
            middle, half = (low + high) / 2, (high - low) / 2
            root = interval.eigenvalue or 0j
            change = interval.after - interval.before
            self._found.thresholds.append(Threshold(middle, half, root, 0.0, change, "count"))

    def _explained(self, low: float, middle: float, high: float) -> list[Threshold]:
        """Return the thresholds of an interval; UnresolvedError if they do not explain its ends."""
        samples = [self._at(each) for each in (low, middle, high)]
        units = units_of(self._window, samples)
        found = [each for unit in units for each in Crossings(self._at, unit).thresholds()]
        sure = [each for each in (low, middle, high) if not self._undecided(each)]
        for one, other in pairwise(sure):
            change = sum(each.change for each in found if one < each.value <= other)
            if self._number(other) - self._number(one) != change:
                raise UnresolvedError
        return found
