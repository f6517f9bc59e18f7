"""Eigenvalues between three values of a parameter: modes are matched and interpolated.

A single eigenvalue is not smooth where it coalesces with another. Of two that come near to each
other the mean and half the distance squared,

    m = (z_1 + z_2) / 2,    s = ((z_1 - z_2) / 2)^2,

are (Kato, Perturbation Theory for Linear Operators, sec. II.1). So modes are single, or pairs
described by m and s, each a cubic Hermite interpolant through values and slopes. z is kappa =
-lambda^2 without damping and lambda with damping.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import assign
from cea.reduced.window import Window

GRID = 17
"""Points of an interpolant in each half of an interval at which its sign is looked at."""
_PARTNERS = 0.5
"""Two modes are a pair where their distance falls below this part of the largest it has."""
_COPIES = 1e-8
"""Relative distance of modes that stay copies of one, the square root of rounding."""
_APART = 0.25
"""Misfit of an interpolant, in its distance from the next mode, that may be a mistaken match."""
BEYOND = 1.03
"""Frequency, relative to the end of the window, beyond which modes may have no partner."""
_FAR = 1.075
"""Frequency, relative to the end of the window, beyond which modes are not looked at."""
_CONJUGATES = 1e-14
"""Relative distance up to which two eigenvalues are conjugates."""
_ROUNDING = 64 * float(np.finfo(float).eps)
"""Rounding of the mean of two modes, relative."""


class UnresolvedError(Exception):
    """What three samples do not tell.

    ``at`` is where another sample would help, None where nothing points to a place; ``noise`` the
    error of the samples themselves where that leaves a sign open: further samples help where theirs
    is less.
    """

    def __init__(self, at: float | None = None, noise: float = 0.0) -> None:
        super().__init__()
        self.at, self.noise = at, noise


@dataclass(frozen=True)
class Sample:
    """The spectrum at a value: with damping lambda of both half planes, without it kappa.

    z and derivatives; bounds on the errors of z, and of the mean of the cluster of each, by the
    numbers of these, shape (n,); right eigenvectors of unit length in one basis for all values,
    shape (k, n).
    """

    value: float
    z: Complexes
    slopes: Complexes
    errors: Floats
    means: Floats
    clusters: Ints
    vectors: Complexes

    def with_mirror_image(self) -> "Sample":
        """It with the conjugates of lambda below the real axis."""
        above = np.flatnonzero(self.z.imag > 0)
        numbers = self.clusters, self.clusters.max(initial=0) + 1 + self.clusters[above]
        return Sample(
            self.value,
            np.concatenate([self.z, self.z[above].conj()]),
            np.concatenate([self.slopes, self.slopes[above].conj()]),
            np.concatenate([self.errors, self.errors[above]]),
            np.concatenate([self.means, self.means[above]]),
            np.concatenate(numbers),
            np.hstack([self.vectors, self.vectors[:, above].conj()]),
        )


@dataclass(frozen=True)
class Hermite:
    """Two cubics through values and slopes at three places, whose values have an error ``noise``.

    The error of a cubic is largest in the middle: what the cubic over the whole interval misses
    there bounds the error of the two, which is sixteen times smaller.
    """

    places: Floats
    values: Complexes | Floats
    slopes: Complexes | Floats
    noise: float

    @cached_property
    def misfit(self) -> float:
        """Bound on the error but for that of the values."""
        (a, c, b), f, d = self.places, self.values, self.slopes
        h, u = b - a, (c - a) / (b - a)
        slope = (f[2] - f[0]) * 6 * u * (1 - u) / h
        slope += d[0] * (1 - u) * (1 - 3 * u) + d[2] * u * (3 * u - 2)
        value = _cubic(np.array(u), h, f[0], d[0], f[2], d[2])
        return float((abs(value - f[1]) + h / 4 * abs(slope - d[1])) / (4 * u * (1 - u)) ** 2)

    def __call__(self, at: Floats) -> Floats | Complexes:
        """Values at places, shape (n,)."""
        a, c, b = self.places
        low = _cubic((at - a) / (c - a), c - a, *self._ends(0, 1))
        high = _cubic((at - c) / (b - c), b - c, *self._ends(1, 2))
        values: Floats | Complexes = np.where(at <= c, low, high)
        return values

    def error(self, at: Floats) -> Floats:
        """Bounds on the errors there, shape (n,)."""
        a, c, b = self.places
        u = np.where(at <= c, (at - a) / (c - a), (at - c) / (b - c))
        bubble: Floats = self.misfit * (4 * u * (1 - u)) ** 2 + self.noise
        return bubble

    def _ends(self, low: int, high: int) -> tuple[complex, complex, complex, complex]:
        return self.values[low], self.slopes[low], self.values[high], self.slopes[high]


def _cubic(u: Floats, h: float, f0: complex, d0: complex, f1: complex, d1: complex) -> Complexes:
    """The cubic through values and slopes at both ends of an interval of width h, u in 0..1."""
    low = (f0 * (1 + 2 * u) + h * d0 * u) * (1 - u) ** 2
    high = (f1 * (3 - 2 * u) + h * d1 * (u - 1)) * u * u
    return np.asarray(low + high)


@dataclass(frozen=True)
class Unit:
    """A mode, whose z is ``mean``, or a pair with m and s; and how many modes are the same."""

    window: Window
    mean: Hermite
    half: Hermite | None
    copies: int

    def members(self, at: Floats) -> Complexes:
        """The z of its modes at places, shape (1 or 2, n)."""
        mean = np.asarray(self.mean(at), complex)
        if self.half is None:
            return mean[None]
        root = np.sqrt(np.asarray(self.half(at), complex))
        return np.stack([mean + root, mean - root])

    def doubts(self, at: Floats) -> Floats:
        """Bounds on the errors of lambda of its modes (1/s), shape (n,)."""
        error = self.mean.error(at)
        if self.half is not None:
            root, own = np.sqrt(np.abs(self.half(at))), self.half.error(at)
            error = error + np.minimum(np.sqrt(own), own / np.maximum(2 * root, _TINY))
        least = np.abs(self.members(at)).min(axis=0).astype(complex)
        return self.window.doubts(least, error)


_TINY = float(np.finfo(float).tiny)


def units_of(window: Window, samples: Sequence[Sample]) -> list[Unit]:
    """Modes and pairs between three samples at rising values; UnresolvedError if not told apart."""
    chains = _chains(window, samples)
    if not len(chains):
        return []
    chains, copies = _without_copies(samples, chains)
    z, slopes = (
        np.array([getattr(each, name)[chains[:, i]] for i, each in enumerate(samples)])
        for name in ("z", "slopes")
    )
    places = np.array([each.value for each in samples])
    partner = _partners(window, places, z, slopes)
    units = []
    for one, other in enumerate(partner):
        members = np.array([one] if other < 0 else sorted({one, int(other)}))
        if members[0] != one or window.far(z[:, members], _FAR).all():
            continue
        unit = _unit(window, samples, chains[members], z[:, members], slopes[:, members])
        unit = Unit(window, unit.mean, unit.half, int(copies[members].min()))
        others = np.delete(z[1], members)
        gap = np.abs(others[:, None] - z[1, members]).min(initial=np.inf)
        if not unit.mean.misfit <= _APART * gap:
            raise UnresolvedError
        units.append(unit)
    return units


def _chains(window: Window, samples: Sequence[Sample]) -> Ints:
    """Numbers of each mode in the three samples, shape (n, 3)."""
    first, last = _matched(*samples[:2]), _matched(*samples[1:])
    following = dict(last.tolist())
    rows = [(i, j, following[j]) for i, j in first.tolist() if j in following]
    chains = np.array(rows, dtype=np.int64).reshape(-1, 3)
    for number, sample in enumerate(samples):
        alone = np.setdiff1d(np.arange(len(sample.z)), chains[:, number])
        if not window.far(sample.z[alone], BEYOND).all():
            raise UnresolvedError
    return chains


def _matched(one: Sample, other: Sample) -> Ints:
    """Pairs of modes by their shapes, and by how well the trapezoidal rule joins eigenvalues."""
    step = (other.value - one.value) / 2
    moved = other.z - one.z[:, None]
    foreseen = step * (one.slopes[:, None] + other.slopes)
    size = np.abs(moved) + np.abs(step) * (np.abs(one.slopes)[:, None] + np.abs(other.slopes))
    with np.errstate(invalid="ignore"):
        misfit = np.nan_to_num(np.abs(moved - foreseen) / (size + _TINY), nan=1.0)
    likeness = np.abs(one.vectors.conj().T @ other.vectors) ** 2
    return np.stack(assign(misfit + 1 - likeness), axis=1)


def _without_copies(samples: Sequence[Sample], chains: Ints) -> tuple[Ints, Ints]:
    """Modes that stay together at all samples once, and how many each stands for."""
    z = np.stack([each.z[chains[:, i]] for i, each in enumerate(samples)], axis=1)
    near = np.abs(z[:, None] - z[None]) <= _COPIES * np.abs(z)[:, None]
    first = near.all(axis=2).argmax(axis=1)
    kept, copies = np.unique(first, return_counts=True)
    return chains[kept], copies


def _partners(window: Window, places: Floats, z: Complexes, slopes: Complexes) -> Ints:
    """The partner of each mode, -1 of single ones; z and slopes of shape (3, n).

    Raises UnresolvedError when one has two.
    """
    half = (z[:, :, None] - z[:, None]) / 2
    with np.errstate(invalid="ignore"):
        square, slope = half**2, half * (slopes[:, :, None] - slopes[:, None])
    low, high = np.abs(square).min(axis=0), np.abs(square).max(axis=0)
    for i in range(2):
        h = float(places[i + 1] - places[i])
        for u in np.linspace(0, 1, GRID)[1:-1]:
            ends = (square[i], slope[i], square[i + 1], slope[i + 1])
            with np.errstate(invalid="ignore"):
                between = np.abs(_cubic(u, h, *ends))
            low, high = np.fmin(low, between), np.fmax(high, between)
    near = low <= _PARTNERS**2 * high
    if not window.damped:
        mirrored = np.abs(z[:, :, None] - z[:, None].conj()) <= _CONJUGATES * np.abs(z)[:, :, None]
        near |= (mirrored & (z.imag != 0)[:, :, None]).any(axis=0)
    np.fill_diagonal(near, False)
    far = window.far(z, _FAR).all(axis=0)
    near &= ~(far[:, None] & far)
    if (near.sum(axis=1) > 1).any():
        raise UnresolvedError
    return np.where(near.any(axis=1), near.argmax(axis=1), -1)


def _unit(
    window: Window, samples: Sequence[Sample], chains: Ints, z: Complexes, slopes: Complexes
) -> Unit:
    """A mode or a pair, z and slopes of shape (3, 1 or 2)."""
    places = np.array([each.value for each in samples])
    errors, means, numbers = (
        np.array([getattr(each, name)[chains[:, i]] for i, each in enumerate(samples)])
        for name in ("errors", "means", "clusters")
    )
    if len(chains) == 1:
        real = not window.damped and not z.imag.any()
        mode = [each.real if real else each for each in (z[:, 0], slopes[:, 0])]
        return Unit(window, _hermite(places, mode, errors.max()), None, 1)
    together = numbers[:, 0] == numbers[:, 1]
    half, error = (z[:, 0] - z[:, 1]) / 2, errors.max(axis=1)
    with np.errstate(invalid="ignore"):
        parts = [z.mean(axis=1), slopes.mean(axis=1), half**2, half * (slopes[:, 0] - slopes[:, 1])]
    told = parts if window.damped else [part.real for part in parts]
    rounding = _ROUNDING * np.abs(z).max(axis=1)
    of_mean = np.where(together, means.max(axis=1), rounding).max()
    of_half = error_of_half(np.abs(half), error, together=together).max()
    mean, square = _hermite(places, told[:2], of_mean), _hermite(places, told[2:], of_half)
    return Unit(window, mean, square, 1)


def error_of_half(distance: Floats, error: Floats, *, together: NDArray[np.bool_]) -> Floats:
    """Error of s of a pair from half the distance and the larger error of its members.

    Where both are judged together Elsner's bound of a member is the root of that of s.
    """
    return np.where(together, error**2, (2 * distance + error) * error)


def _hermite(places: Floats, told: Sequence[Floats | Complexes], noise: float) -> Hermite:
    """An interpolant of values and slopes."""
    values, slopes = told
    if not np.isfinite(slopes).all():
        raise UnresolvedError
    return Hermite(places, values, slopes, float(noise))
