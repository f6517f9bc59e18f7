"""Error bars of numbers on a sequence of meshes, and of the eigenvalues that are made of them.

The bar is twice the larger of two estimates of the error on the finest mesh: Richardson's, by the
order observed on three meshes, and the change by inverse iteration in a richer space.

Two eigenvalues z of a pair near a coalescence, lambda^2 without damping and lambda with, are
m +- sqrt(s). Mean m and splitting s = ((z1 - z2) / 2)^2 vary smoothly with the mesh where the
members do not, so that bars of a pair are made of those of m and s.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

import numpy as np

from cea.arrays import Complexes
from comparisons.converge.ladder import MESHES, RATIO

FACTOR = 2.0
"""Bar over the larger estimate: 99.9 per cent of eigenvalues with known errors lie within it."""
LEAST_ORDER = 1.0
"""Least order of convergence by which Richardson's error is extrapolated."""
CONVERGING = 1.2
"""Least ratio of two differences of a sequence that converges."""


@dataclass(frozen=True)
class Bar:
    """Error bar of the last number of a sequence."""

    size: float
    converges: bool = True  # whether differences fall
    estimates: int = 2  # 1 where meshes are too few or have no ratio


def bar_of(
    numbers: Sequence[complex], corrected: complex, degree: int, rounding: float = 0.0
) -> Bar:
    """Error bar of the last of the numbers on some meshes, coarsest first.

    Richardson's error takes the last three, of meshes of the same ratio; differences fall by it to
    twice the degree at most. Each number has an error by rounding.
    """
    change = abs(corrected - numbers[-1])
    if len(numbers) < MESHES:
        return Bar(FACTOR * change + rounding, estimates=1)
    first, second = np.abs(np.diff(numbers[-MESHES:])).tolist()
    size = max(first + second, FACTOR * change)
    if first + second <= 2 * rounding:  # nothing but rounding differs
        return Bar(size + rounding)
    if first < CONVERGING * second:
        return Bar(size + rounding, converges=False)
    most = RATIO ** (2 * degree)
    ratio = min(max(first / second if second else most, RATIO**LEAST_ORDER), most)
    return Bar(FACTOR * max(second / (ratio - 1), change) + rounding)


@dataclass(frozen=True)
class Estimated:
    """An eigenvalue lambda (1/s) with error bars of Im lambda and of Re lambda (1/s)."""

    value: complex
    frequency_bar: float
    growth_bar: float
    converges: bool = True
    estimates: int = 2
    still: bool = False  # it cannot grow for the structure of the problem
    is_open: bool = False  # it may have coalesced with another or not: growth is not known


def splitting(pairs: Complexes) -> Any:
    """((a - b) / 2)^2 of the pairs along the last axis."""
    return ((pairs[..., 0] - pairs[..., 1]) / 2) ** 2


def single(
    values: Complexes,
    corrected: complex,
    degree: int,
    rounding: float,
    *,
    damped: bool,
) -> Estimated:
    """An eigenvalue by itself; without damping one of no growth on all meshes has none."""
    bar = bar_of(values.tolist(), corrected, degree, rounding)
    value, still = complex(values[-1]), bool(not damped and np.all(values.real == 0))
    growth = 0.0 if still else bar.size
    return Estimated(value, bar.size, growth, bar.converges, bar.estimates, still)


def pair(
    values: Complexes,
    corrected: Complexes,
    degree: int,
    rounding: float,
    *,
    damped: bool,
) -> tuple[Estimated, Estimated]:
    """Two eigenvalues by their mean and splitting, values of shape (meshes, 2).

    Without damping both are still where the splitting lies above its bar, flutter where it lies
    below minus its bar, and else grow by no more than what the splitting minus its bar gives.
    """
    z = values if damped else values**2
    means, splittings = z.mean(axis=1), splitting(z)
    richer = corrected if damped else corrected**2
    size, root = abs(means[-1]), abs(splittings[-1])
    of_member = rounding if damped else 2 * sqrt(size) * rounding + rounding**2
    of_mean = bar_of(means.tolist(), complex(richer.mean()), degree, of_member)
    of_splitting = 2 * sqrt(root) * of_member + of_member**2
    of_root = bar_of(splittings.tolist(), splitting(richer), degree, of_splitting)
    copies = bool((np.abs(splittings) <= of_splitting).all())
    error = root_error(root, of_root.size)
    converges = of_mean.converges and of_root.converges
    estimates = min(of_mean.estimates, of_root.estimates)
    found = []
    for value in values[-1].tolist():
        if damped:
            both = of_mean.size + error
            found.append(Estimated(value, both, both, converges, estimates))
            continue
        is_open = root <= of_root.size and not (copies and value.real == 0)
        frequency, growth = _of_member(value, of_mean.size, error)
        if is_open:
            speed = max(abs(value), np.finfo(float).tiny)
            growth = sqrt(root + of_root.size) / (2 * speed)
            frequency = (of_mean.size + error) / (2 * speed)
        still = not is_open and value.real == 0
        found.append(Estimated(value, frequency, growth, converges, estimates, still, is_open))
    return found[0], found[1]


def opened(one: Estimated, apart: float, bar: float) -> Estimated:
    """An eigenvalue that was still, beside one with which it may have coalesced.

    Their splitting has a size and a bar.
    """
    growth = sqrt(apart + bar) / (2 * abs(one.value))
    return replace(one, growth_bar=max(one.growth_bar, growth), still=False, is_open=True)


def root_error(square: float, error: float) -> float:
    """Error of a root from that of its square: half of it relative, or its root."""
    return sqrt(square) - sqrt(square - error) if error < square else sqrt(square + error)


def _of_member(value: complex, of_mean: float, of_root: float) -> tuple[float, float]:
    """Bars of Im and Re lambda, lambda^2 = m +- sqrt(s), from those of m and of sqrt(s)."""
    growth, frequency = abs(value.real), abs(value.imag)
    speed = max(abs(value), np.finfo(float).tiny)
    if growth == 0:
        return (of_mean + of_root) / (2 * speed), 0.0
    if frequency == 0:
        return 0.0, (of_mean + of_root) / (2 * speed)
    # Of a pair that flutters lambda = g + i w: m = g^2 - w^2, sqrt(-s) = 2 g w.
    return (
        (frequency * of_mean + growth * of_root) / (2 * speed**2),
        (frequency * of_root + growth * of_mean) / (2 * speed**2),
    )
