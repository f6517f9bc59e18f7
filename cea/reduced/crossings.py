"""Thresholds of a mode or a pair between three samples, where it begins or ceases to grow.

They are zeros of a function that is positive where modes grow: -kappa of an undamped mode, -s of an
undamped pair, otherwise the growth rate above a level (:mod:`cea.reduced.following`). Its roots are
found on the interpolant, and refined by Newton's method on the pencil itself.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from cea.arrays import Complexes, Floats
from cea.eigen.matching import assign
from cea.eigen.spectrum import SLOW
from cea.reduced.following import Sample, Unit, UnresolvedError, error_of_half, grid_of
from cea.reduced.spectrum import Window

_NEGLIGIBLE = 1e-6
"""Relative error of lambda up to which an undecided sign is accepted."""
REAL = 1e-9
"""Frequency relative to the end of the window below which an eigenvalue counts as real."""
NEAR = 1e-3
"""Distance from a sample, relative to the interval, below which a place counts as that sample."""
_ROUNDING = 4.0
"""Error of an interpolant relative to that of its samples below which it is due to theirs."""
_STEPS = 8
"""Largest number of Newton steps."""
_CONVERGED = 1e-12
"""Size of a Newton step relative to the parameter at convergence."""
_STRAY = 0.1
"""Distance relative to the interval by which Newton's method may leave it."""
_TINY = float(np.finfo(float).tiny)

Function = Callable[[Any], Any]
"""Function of one value of the parameter, or of an array."""
Quantity = Literal["growth", "coalescence", "zero", "end"]
"""Function whose zeros are thresholds (:func:`passing`)."""
_KINDS: dict[Quantity, tuple[str, int]] = {
    "growth": ("flutter", 2),
    "coalescence": ("flutter", 2),
    "zero": ("divergence", 1),
    "end": ("window", 2),
}
"""Kind of threshold, and number of eigenvalues of both half planes that begin to grow."""


@dataclass(frozen=True)
class Threshold:
    """A value at which the number of growing modes changes, with a bound on its error.

    ``eigenvalue`` is lambda there (1/s), Im lambda >= 0. ``slope`` is the derivative of the
    function that vanishes (:func:`passing`), or zero where only the numbers of growing modes on
    both sides are known. ``change`` is that of the number of growing eigenvalues of the window, of
    both half planes, as the parameter rises. ``kind`` is "flutter", "divergence", "window" where a
    growing mode passes the end of the window, or "count" where only the numbers are known.
    """

    value: float
    error: float
    eigenvalue: complex
    slope: float
    change: int
    kind: str


def passing(window: Window, of: Quantity, z: Any) -> Any:
    """Return the function whose zeros are thresholds, shape (modes, ...).

    It is positive where modes grow in the window: the growth rate minus the level (1/s), -s of two
    undamped modes that coalesce (1/s^4), -kappa of one (1/s^2), or the end of the window minus the
    frequency (rad/s).
    """
    if of == "coalescence":
        return -(((z[:1] - z[1:]) / 2) ** 2).real
    if of == "zero":
        return -z.real
    return window.growth(z) if of == "growth" else window.end - window.roots(z).imag


def growing_root(window: Window, of: Quantity, z: Complexes) -> complex:
    """Return lambda of a growing mode, or of both modes of a pair, at a threshold."""
    if of == "zero":
        return 0j
    mean = z.mean().real if of == "coalescence" else z[0]
    root = complex(window.roots(np.array([mean]))[0])
    return root if window.damped else complex(abs(root.real), root.imag)


class Crossings:
    """Thresholds of one unit between three samples; ``at`` returns the sample at a value."""

    def __init__(self, at: Callable[[float], Sample], unit: Unit) -> None:
        self.at, self.unit, self.window = at, unit, unit.window
        self._places = unit.mean.places
        self._grid, self._width = grid_of(self._places), float(np.ptp(self._places))

    def thresholds(self) -> Iterator[Threshold]:
        """Yield all thresholds of the interval.

        UnresolvedError when a sign is undecided, or Newton's method disagrees with the interpolant.
        """
        window, unit = self.window, self.unit
        roots = window.roots(unit.members(self._grid))
        if (roots.imag < -REAL * window.end).all():  # conjugates of other modes
            return
        members, speed = len(roots), max(float(np.abs(roots).min()), SLOW * window.end)
        negligible = _NEGLIGIBLE * speed
        if window.by_growth:  # the least and the largest of a pair
            for branch in range(members):
                yield from self._crossed("growth", branch, unit.doubts, negligible)
        elif unit.half is None:
            yield from self._crossed("zero", 0, unit.errors, 2 * negligible * speed)
        else:
            least = (2 * negligible * speed) ** 2
            yield from self._crossed("coalescence", 0, unit.half.error, least)
            for branch in range(members):
                yield from self._crossed("zero", branch, unit.errors)
        conjugates = not window.damped and unit.half is not None
        for branch in range(1 if conjugates else members):
            yield from self._crossed("end", branch, unit.doubts)

    def _crossed(
        self, of: Quantity, branch: int, error: Function, negligible: float | None = None
    ) -> Iterator[Threshold]:
        """Yield the zeros of a quantity; with ``negligible`` all its signs must be certain.

        Signs may then be undecided only where the error is below ``negligible``.
        """

        def value(at: Any) -> Any:
            values = passing(self.window, of, self.unit.members(at))
            return np.sort(values, axis=0)[branch] if of == "growth" else values[branch]

        known = np.zeros_like if negligible is None else error
        for place, sign in self._sure_roots(value, known, negligible or 0.0):
            if self._counts(of, branch, place):
                h = 1e-4 * self._width
                rate = max(abs(value(place + h) - value(place - h)) / (2 * h), _TINY)
                off = 2 * float(error(place)) / rate + REAL * self._width
                yield self._threshold(of, branch, place, sign, off)

    def _counts(self, of: Quantity, branch: int, place: float) -> bool:
        """Whether a zero changes the number of growing modes of the window."""
        window, unit = self.window, self.unit
        z = unit.members(place)
        if of == "coalescence":
            return bool(0 < unit.mean(place).real <= window.end**2)
        if of == "zero":
            return unit.half is None or bool(unit.half(place).real > unit.half.error(place))
        if of == "end":
            return bool(window.growth(z)[branch] > unit.doubts(place))
        root = window.roots(z)[np.argmin(np.abs(window.growth(z)))]
        oscillates = abs(root.imag) > REAL * window.end
        mirrored = len(z) == 2 and abs(z[0] - z[1].conj()) <= REAL * abs(z[0])
        seen_twice = mirrored and oscillates and branch == 0
        return not seen_twice and bool(-REAL * window.end <= root.imag <= window.end)

    def _threshold(
        self, of: Quantity, branch: int, start: float, sign: int, off: float
    ) -> Threshold:
        """Refine a root of an interpolant on the pencil itself; it may move by at most ``off``."""
        (low, _, high), stray, place = self._places, _STRAY * self._width, start
        for _ in range(_STEPS):
            sample, foreseen = self.at(place), self.unit.members(place)
            rows, columns = assign(np.abs(sample.z[:, None] - foreseen))
            if len(rows) < len(foreseen):
                raise UnresolvedError(place)
            modes = sample[rows[np.argsort(columns)]]
            if of != "coalescence":
                near = passing(self.window, of, modes.z)
                if of == "end":
                    near = self.window.roots(modes.z) - self.window.roots(foreseen)[branch]
                modes = modes[np.argsort(np.abs(near))[:1]]
            value, slope, doubt = self._followed(of, modes)
            if not (np.isfinite(slope) and slope != 0):
                raise UnresolvedError(place)
            step, error = -value / slope, (abs(value) + doubt) / abs(slope)
            if abs(value) <= doubt or abs(step) <= _CONVERGED * max(abs(place), self._width):
                break
            if not low - stray <= place + step <= high + stray:
                raise UnresolvedError(place)
            place += step
        else:
            raise UnresolvedError(place)
        if abs(place - start) > off:
            raise UnresolvedError(start)
        root = growing_root(self.window, of, modes.z)
        real = of == "growth" and abs(root.imag) <= REAL * self.window.end
        kind, change = _KINDS["zero" if real else of]
        return Threshold(
            value=float(place),
            error=float(error),
            eigenvalue=complex(root.real, abs(root.imag)),
            slope=float(slope),
            change=sign * change * self.unit.copies,
            kind=kind,
        )

    def _followed(self, of: Quantity, modes: Sample) -> tuple[float, float, float]:
        """Return the function of :func:`passing` of a mode or a pair, its slope and its error."""
        window, z, error = self.window, modes.z, modes.errors.max()
        value, slope = passing(window, of, z)[0], -modes.slopes[0]
        if of == "coalescence":
            half, together = (z[0] - z[1]) / 2, modes.clusters[0] == modes.clusters[1]
            slope = half * (modes.slopes[1] - modes.slopes[0])
            error = error_of_half(abs(half), error, together=together)
        elif of != "zero":
            error, speed = window.doubts(z, modes.errors)[0], window.root_slopes(z, modes.slopes)[0]
            grows = window.damped or window.roots(z)[0].real >= 0
            slope = (speed if grows else -speed) if of == "growth" else 1j * speed
        return float(value), float(slope.real), float(error)

    def _sure_roots(
        self, function: Function, error: Function, negligible: float
    ) -> Iterator[tuple[float, int]]:
        """Yield roots of an interpolant with the sign after each; UnresolvedError if one is unsure.

        Zero within the error of the samples is accepted where that error is negligible.
        """
        grid, width = self._grid, self._width
        values, errors = function(grid), error(grid)
        own = _ROUNDING * float(error(self._places).max())
        noise = min(own, negligible)
        signs = np.where(values > errors, 1, np.where(values < -errors, -1, 0))
        sure = np.flatnonzero(signs)
        if not len(sure):
            if np.abs(values).max() > noise:
                raise UnresolvedError
            return  # zero within rounding throughout
        for unsure in (grid[: sure[0]], grid[sure[-1] + 1 :]):
            if len(unsure) and error(unsure).max() > noise:
                raise UnresolvedError(float(unsure[len(unsure) // 2]))
        for i, j in pairwise(sure):
            if signs[i] != signs[j]:
                rises = (np.diff(values[i : j + 1]) * signs[j] > 0).all()
                if j > i + 1 and not rises and errors[i : j + 1].max() > noise:
                    raise UnresolvedError(float(grid[(i + j) // 2]))
                yield _root(function, grid[i], grid[j]), int(signs[j])
                continue
            nearest = min(values[i] * signs[i], values[j] * signs[i])
            if j == i + 1 and nearest > 2 * abs(values[j] - values[i]) + errors[i] + errors[j]:
                continue
            self._check_apart(grid[i + 1 : j], noise)
            sign, bounds = int(signs[i]), (grid[i], grid[j])
            options = {"xatol": 1e-12 * (grid[j] - grid[i])}
            approach = minimize_scalar(
                lambda t, sign=sign: sign * function(t), bounds=bounds, options=options
            )
            place, least = float(approach.x), float(approach.fun)
            doubt = float(error(place))
            if least < -doubt:
                yield _root(function, grid[i], place), -sign
                yield _root(function, place, grid[j]), sign
            elif least <= doubt:
                aside = min(abs(place - each) for each in self._places) > NEAR * width
                if doubt > noise or aside:
                    raise UnresolvedError(place)

    def _check_apart(self, places: Floats, noise: float) -> None:
        """Raise UnresolvedError where a damped pair may coalesce: its growth is flat before."""
        half = self.unit.half
        if half is None or not self.window.by_growth or not len(places):
            return
        open_ = (np.abs(half(places)) <= half.error(places)) & (self.unit.doubts(places) > noise)
        if open_.any():
            raise UnresolvedError(float(places[open_][0]))


def _root(function: Function, low: float, high: float) -> float:
    if function(low) * function(high) >= 0:
        return (low + high) / 2
    return float(brentq(function, low, high, xtol=1e-15 * max(abs(low), abs(high)) + _TINY))
