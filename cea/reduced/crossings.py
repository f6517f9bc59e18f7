"""Where a mode or a pair begins or ceases to grow between three samples.

A function is positive where modes grow: -kappa of an undamped mode, -s of an undamped pair, growth
above a level otherwise (:mod:`cea.reduced.following`). Its roots are found on its interpolant, and
then by Newton's method on the pencil itself.
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
from cea.reduced.following import GRID, Sample, Unit, UnresolvedError, error_of_half, grid_of
from cea.reduced.window import Window

_NEGLIGIBLE = 1e-6
"""Error of lambda, relative, up to which it does not matter whether a mode grows."""
REAL = 1e-9
"""Frequency, relative to the window's end, below which an eigenvalue is real."""
_NEAR = 1e-3
"""Part of an interval next to its samples in which a place counts as one of them."""
_ROUNDING = 4.0
"""Error of an interpolant, in that of its samples, up to which it is nothing but theirs."""
_STEPS = 8
"""Steps of Newton's method."""
_CONVERGED = 1e-12
"""Last step of it, relative to the parameter."""
_SURELY = 1e-6
"""Error of a root, relative to the interval, up to which it is one though steps have not ended."""
_STRAY = 0.1
"""Part of an interval by which Newton's steps may leave it."""
_TINY = float(np.finfo(float).tiny)

Function = Callable[[Any], Any]
"""Of one place or of several."""
Quantity = Literal["growth", "coalescence", "zero", "end"]
"""What passes zero: growth above the level, s of a pair, kappa, frequency less the window's end."""
_KINDS: dict[Quantity, tuple[str, int]] = {
    "growth": ("flutter", 2),
    "coalescence": ("flutter", 2),
    "zero": ("divergence", 1),
    "end": ("window", 2),
}
"""What begins there, and how many eigenvalues of both half planes then grow."""


@dataclass(frozen=True)
class Threshold:
    """A value at which the number of growing modes changes, with a bound on its error.

    lambda there (1/s), Im lambda >= 0. The derivative of what passes zero: growth rate (1/s), s of
    an undamped pair (1/s^4), kappa of an undamped mode (1/s^2), frequency (rad/s) at the window's
    end; zero where only the numbers of growing modes on both sides are known. The change of the
    number of growing eigenvalues of the window, of both half planes, as the parameter rises. The
    kind is "flutter", "divergence", "window" where a growing mode passes the window's end, or
    "count" where only the numbers on both sides are known.
    """

    value: float
    error: float
    eigenvalue: complex
    slope: float
    change: int
    kind: str


@dataclass(frozen=True)
class Crossings:
    """What one unit does between three samples at rising ``places``; ``at`` gives spectra."""

    window: Window
    at: Callable[[float], Sample]
    unit: Unit
    places: tuple[float, float, float]

    def thresholds(self) -> Iterator[Threshold]:
        """All thresholds of the interval.

        Raises UnresolvedError when a sign is not sure, or Newton's method leaves the interpolant.
        """
        roots = self.window.roots(self.unit.members(self._grid))
        if (roots.imag < -REAL * self.window.end).all():  # conjugates of others
            return
        speed = max(float(np.abs(roots).min()), SLOW * self.window.end)
        if self.window.by_growth:
            yield from self._by_growth(_NEGLIGIBLE * speed)
        else:
            yield from self._undamped(2 * _NEGLIGIBLE * speed**2)
        yield from self._through_the_end(len(roots))

    @property
    def _grid(self) -> Floats:
        return grid_of(self.places)

    @property
    def _width(self) -> float:
        return self.places[2] - self.places[0]

    def _by_growth(self, negligible: float) -> Iterator[Threshold]:
        """Growth rates through the level: of a pair the larger and the smaller one."""
        end = self.window.end
        for number in range(2 if self.unit.half is not None else 1):

            def growth(at: Floats, number: int = number) -> Floats:
                rates = self.window.growth(self.unit.members(at))
                chosen: Floats = rates.min(axis=0) if number else rates.max(axis=0)
                return chosen

            for place, sign in self._roots(growth, self.unit.doubts, negligible):
                z = self.unit.members(place)
                mode = int(np.argmin(np.abs(self.window.growth(z))))
                root = complex(self.window.roots(z)[mode])
                real = abs(root.imag) <= REAL * end
                mirrored = len(z) == 2 and abs(z[0] - z[1].conj()) <= REAL * abs(z[0]) and not real
                if (mirrored and number) or not -REAL * end <= root.imag <= end:
                    continue
                yield self._threshold(place, sign, "growth", growth, self.unit.doubts)

    def _undamped(self, negligible: float) -> Iterator[Threshold]:
        """Zeros of kappa, and of s where kappa is positive."""
        mean, half = self.unit.mean, self.unit.half
        if half is None:

            def single(at: Floats) -> Floats:
                return -mean(at).real

            for place, sign in self._roots(single, mean.error, negligible):
                yield self._threshold(place, sign, "zero", single, mean.error)
            return

        def apart(at: Floats) -> Floats:
            return -half(at).real

        for place, sign in self._roots(apart, half.error, negligible**2):
            if 0 < mean(place).real <= self.window.end**2:
                yield self._threshold(place, sign, "coalescence", apart, half.error)
        for branch in (1.0, -1.0):

            def through(at: Floats, branch: float = branch) -> Floats:
                return -(mean(at).real + branch * np.sqrt(np.maximum(half(at).real, 0.0)))

            def error(at: Floats) -> Floats:
                return mean.error(at) + half.error(at) / (2 * np.sqrt(np.abs(half(at)) + _TINY))

            for place, sign in _signs(through, self._grid):
                if half(place).real > half.error(place):
                    yield self._threshold(place, sign, "zero", through, error)

    def _through_the_end(self, members: int) -> Iterator[Threshold]:
        """Growing modes through the window's end."""
        conjugate = not self.window.damped and self.unit.half is not None
        for branch in range(1 if conjugate else members):

            def within(at: Floats, branch: int = branch) -> Floats:
                return self.window.end - self.window.roots(self.unit.members(at))[branch].imag

            for place, sign in _signs(within, self._grid):
                if self._grows(place, branch):
                    yield self._threshold(place, sign, "end", within, None, branch)

    def _grows(self, at: float, branch: int) -> bool:
        half = self.unit.half
        if self.window.by_growth:
            growth = self.window.growth(self.unit.members(at))[branch]
            return bool(growth > self.unit.doubts(at))
        return half is not None and bool(half(at).real < -half.error(at))

    def _threshold(
        self,
        start: float,
        sign: int,
        of: Quantity,
        function: Function,
        error: Function | None,
        branch: int = 0,
    ) -> Threshold:
        """A root of an interpolant, improved on the pencil itself and not far from it there."""
        (low, _, high), stray, place = self.places, _STRAY * self._width, start
        for _ in range(_STEPS):
            sample, foreseen = self.at(place), self.unit.members(place)
            rows, columns = assign(np.abs(sample.z[:, None] - foreseen))
            if len(rows) < len(foreseen):
                raise UnresolvedError(place)
            modes = sample[rows[np.argsort(columns)]]
            value, slope, doubt, root = self._followed(modes, of, foreseen[branch])
            if not (np.isfinite(slope) and slope != 0):
                raise UnresolvedError(place)
            step, off = -value / slope, (abs(value) + doubt) / abs(slope)
            if abs(value) <= doubt or abs(step) <= _CONVERGED * max(abs(place), self._width):
                break
            if not low - stray <= place + step <= high + stray:
                raise UnresolvedError(place)
            place += step
        else:
            if off > _SURELY * self._width:
                raise UnresolvedError(place)
        if error is not None:
            h = 1e-4 * self._width
            rate = max(abs(function(start + h) - function(start - h)) / (2 * h), _TINY)
            if abs(place - start) > 2 * error(start) / rate + REAL * self._width:
                raise UnresolvedError(start)
        kind, change = _KINDS[of]
        if of == "growth" and abs(root.imag) <= REAL * self.window.end:
            kind, change = _KINDS["zero"]
        return Threshold(
            value=float(place),
            error=float(off),
            eigenvalue=complex(root.real, abs(root.imag)),
            slope=float(slope),
            change=sign * change * self.unit.copies,
            kind=kind,
        )

    def _followed(
        self, modes: Sample, of: Quantity, foreseen: complex
    ) -> tuple[float, float, float, complex]:
        """What has a root, its slope and its error at the modes of the unit, and lambda."""
        window, z = self.window, modes.z
        if of == "coalescence":
            value, root = passing(window, of, z)
            half, together = (z[0] - z[1]) / 2, modes.clusters[0] == modes.clusters[1]
            slope = (half * (modes.slopes[0] - modes.slopes[1])).real
            doubt = error_of_half(abs(half), modes.errors.max(), together=together)
            return value, float(slope), float(doubt), root
        if of == "end":
            chosen = np.abs(window.roots(z) - window.roots(np.array([foreseen])))
        else:
            chosen = np.abs(z) if of == "zero" else np.abs(window.growth(z))
        mode = modes[np.argsort(chosen)[:1]]
        value, root = passing(window, of, mode.z)
        if of == "zero":
            return value, float(mode.slopes[0].real), float(mode.errors[0]), root
        doubt = float(window.doubts(mode.z, mode.errors)[0])
        upper = complex(window.roots(mode.z)[0])
        speed = complex(mode.slopes[0] if window.damped else -mode.slopes[0] / (2 * upper))
        if of == "end":
            return value, speed.imag, doubt, root
        return value, speed.real if root == upper else -speed.real, doubt, root

    def _roots(
        self, function: Function, error: Function, negligible: float
    ) -> Iterator[tuple[float, int]]:
        """Roots of an interpolant with the sign after each; UnresolvedError where a sign is unsure.

        Zero within the error of samples is sure where that error is negligible.
        """
        grid, width = self._grid, self._width
        values, errors = function(grid), error(grid)
        own = _ROUNDING * float(error(np.array(self.places)).max())
        noise = min(own, negligible)
        told = own if noise < errors.max() <= own else 0.0
        signs = np.where(values > errors, 1, np.where(values < -errors, -1, 0))
        sure = np.flatnonzero(signs)
        if not len(sure):
            if np.abs(values).max() > noise:
                raise UnresolvedError(None, told)
            return  # zero within rounding throughout
        for unsure in (grid[: sure[0]], grid[sure[-1] + 1 :]):
            if len(unsure) and error(unsure).max() > noise:
                raise UnresolvedError(float(unsure[len(unsure) // 2]), told)
        for i, j in pairwise(sure):
            by_bounds = told if j - i > GRID // 2 else 0.0
            if signs[i] != signs[j]:
                rises = (np.diff(values[i : j + 1]) * signs[j] > 0).all()
                if j > i + 1 and not rises and errors[i : j + 1].max() > noise:
                    raise UnresolvedError(float(grid[(i + j) // 2]), by_bounds)
                yield _root(function, grid[i], grid[j]), int(signs[j])
                continue
            nearest = min(values[i] * signs[i], values[j] * signs[i])
            if j == i + 1 and nearest > 2 * abs(values[j] - values[i]) + errors[i] + errors[j]:
                continue
            self._check_apart(grid[i + 1 : j], noise, by_bounds)
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
                aside = min(abs(place - each) for each in self.places) > _NEAR * width
                if doubt > noise or aside:
                    raise UnresolvedError(place, by_bounds)

    def _check_apart(self, places: Floats, noise: float, by_bounds: float) -> None:
        """Refuse places at which a damped pair may coalesce: its growth is flat up to there."""
        half = self.unit.half
        if half is None or not self.window.by_growth or not len(places):
            return
        open_ = (np.abs(half(places)) <= half.error(places)) & (self.unit.doubts(places) > noise)
        if open_.any():
            raise UnresolvedError(float(places[open_][0]), by_bounds)


def _signs(function: Function, grid: Floats) -> Iterator[tuple[float, int]]:
    """Roots between places where a function has opposite signs, with the sign after each."""
    values = function(grid)
    for i in np.flatnonzero((values[:-1] > 0) != (values[1:] > 0)):
        yield _root(function, grid[i], grid[i + 1]), 1 if values[i + 1] > 0 else -1


def _root(function: Function, low: float, high: float) -> float:
    if function(low) * function(high) >= 0:
        return (low + high) / 2
    return float(brentq(function, low, high, xtol=1e-15 * max(abs(low), abs(high)) + _TINY))


def passing(window: Window, of: Quantity, z: Complexes) -> tuple[float, complex]:
    """What passes zero of a mode, or of both of a pair, and lambda: that which grows."""
    if of == "coalescence":
        square = ((z[0] - z[1]) / 2) ** 2
        return float(square.real), complex(window.roots(np.array([z.mean().real + 0j]))[0])
    if of == "zero":
        return float(z[0].real), 0j
    root = complex(window.roots(z)[0])
    if not window.damped and root.real < 0:
        root = -root.conjugate()
    return (root.real - window.level if of == "growth" else root.imag - window.end), root
