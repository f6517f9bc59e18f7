"""Error bars of numbers computed on a sequence of meshes, and of eigenvalues.

The bar is twice the larger of two estimates of the error on the finest mesh: Richardson's estimate
with the order observed on three meshes, and the change by inverse iteration in a richer space.

Two eigenvalues z of a pair near a coalescence, lambda^2 without damping and lambda with, are
m +- sqrt(s). The mean m and the splitting s = ((z1 - z2) / 2)^2 vary smoothly with the mesh, while
z1 and z2 do not. The bars of a pair are therefore computed from those of m and s.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

import numpy as np

from cea.arrays import Complexes
from comparisons.converge.ladder import MESHES, RATIO

FACTOR = 2.0
"""Bar over the larger estimate: contains 99.9 per cent of errors against exact eigenvalues."""
LEAST_ORDER = 1.0
"""Smallest order of convergence used in Richardson's estimate."""
CONVERGING = 1.2
"""Ratio of successive differences below which a sequence does not converge."""


@dataclass(frozen=True)
class Bar:
    """Error bar of the last number of a sequence."""

    size: float
    converges: bool = True  # whether differences decrease
    estimates: int = 2  # 1 without Richardson's estimate


def bar_of(
    numbers: Sequence[complex], corrected: complex, degree: int, rounding: float = 0.0
) -> Bar:
    """Return the error bar of the last of some numbers on meshes, coarsest first.

    Richardson's estimate uses the last three, on meshes of one ratio, with an order of at most
    twice the degree. ``rounding`` is the rounding error of each number.
    """
    change = abs(corrected - numbers[-1])
    if len(numbers) < MESHES:
        return Bar(FACTOR * change + rounding, estimates=1)
    first, second = np.abs(np.diff(numbers[-MESHES:])).tolist()
    size = max(first + second, FACTOR * change)
    if first + second <= 2 * rounding:  # differences are rounding only
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
    still: bool = False  # growth is exactly zero by the structure of the problem
    is_open: bool = False  # it may have coalesced with another: growth is undecided


def splitting(pairs: Complexes) -> Any:
    """Return ((a - b) / 2)^2 of the pairs along the last axis."""
    return ((pairs[..., 0] - pairs[..., 1]) / 2) ** 2


def single(
    values: Complexes,
    corrected: complex,
    degree: int,
    rounding: float,
    *,
    damped: bool,
) -> Estimated:
    """Return a single eigenvalue with bars; undamped, zero growth on all meshes is exact."""
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
    """Return a pair with bars from its mean and splitting; ``values`` have shape (meshes, 2).

    Without damping the pair does not grow if the splitting s exceeds its bar, and flutters if s is
    below minus its bar. Otherwise growth is undecided, with a limit from s minus its bar.
    """
    z = values if damped else values**2
    means, splittings = z.mean(axis=1), splitting(z)
    richer = corrected if damped else corrected**2
    size, root = abs(means[-1]), abs(splittings[-1])
    of_member = rounding if damped else 2 * sqrt(size) * rounding + rounding**2
    of_mean = bar_of(means.tolist(), complex(richer.mean()), degree, of_member)
    of_splitting = 2 * sqrt(root) * of_member + of_member**2
    of_root = bar_of(splittings.tolist(), splitting(richer), degree, of_splitting)
    multiple = bool((np.abs(splittings) <= of_splitting).all())
    error = root_error(root, of_root.size)
    converges = of_mean.converges and of_root.converges
    estimates = min(of_mean.estimates, of_root.estimates)
    found = []
    for value in values[-1].tolist():
        if damped:
            both = of_mean.size + error
            found.append(Estimated(value, both, both, converges, estimates))
            continue
        is_open = root <= of_root.size and not (multiple and value.real == 0)
        frequency, growth = _of_member(value, of_mean.size, error)
        if is_open:
            speed = max(abs(value), np.finfo(float).tiny)
            growth = sqrt(root + of_root.size) / (2 * speed)
            frequency = (of_mean.size + error) / (2 * speed)
        still = not is_open and value.real == 0
        found.append(Estimated(value, frequency, growth, converges, estimates, still, is_open))
    return found[0], found[1]


def opened(one: Estimated, apart: float, bar: float) -> Estimated:
    """Return an eigenvalue without growth as undecided: it may have coalesced with another.

    ``apart`` is the size of their splitting, ``bar`` its error bar.
    """
    growth = sqrt(apart + bar) / (2 * abs(one.value))
    return replace(one, growth_bar=max(one.growth_bar, growth), still=False, is_open=True)


def root_error(square: float, error: float) -> float:
    """Return the error of a square root from the error of its square."""
    return sqrt(square) - sqrt(square - error) if error < square else sqrt(square + error)


def _of_member(value: complex, of_mean: float, of_root: float) -> tuple[float, float]:
    """Return bars of Im and Re lambda, lambda^2 = m +- sqrt(s), from those of m and sqrt(s)."""
    growth, frequency = abs(value.real), abs(value.imag)
    speed = max(abs(value), np.finfo(float).tiny)
    if growth == 0:
        return (of_mean + of_root) / (2 * speed), 0.0
    if frequency == 0:
        return 0.0, (of_mean + of_root) / (2 * speed)
    # For a fluttering pair lambda = g + i w, m = g^2 - w^2 and sqrt(-s) = 2 g w.
    return (
        (frequency * of_mean + growth * of_root) / (2 * speed**2),
        (frequency * of_root + growth * of_mean) / (2 * speed**2),
    )
