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
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

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
_TINY = float(np.finfo(float).tiny)


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

    def __getitem__(self, modes: Ints) -> "Sample":
        names = ("z", "slopes", "errors", "means", "clusters", "vectors")
        return Sample(self.value, *(getattr(self, name)[..., modes] for name in names))

    def with_mirror_image(self) -> "Sample":
        """It with the conjugates of lambda below the real axis."""
        modes = np.arange(len(self.z))
        above = modes[self.z.imag > 0]
        both = self[np.concatenate([modes, above])]
        for each in (both.z, both.slopes, both.vectors):
            each.imag[..., len(modes) :] *= -1
        both.clusters[len(modes) :] += 1 + self.clusters.max(initial=0)
        return both


class Hermite:
    """Two cubics through values and slopes at three places, whose values have an error ``noise``.

    The error of a cubic is largest in the middle: what the cubic over the whole interval misses
    there bounds the error of the two, which is sixteen times smaller. ``misfit`` is that bound but
    for the error of the values.
    """

    def __init__(
        self, places: Floats, values: NDArray[np.inexact], slopes: NDArray[np.inexact], noise: float
    ) -> None:
        if not np.isfinite(slopes).all():
            raise UnresolvedError
        self._places, self._noise = places, noise
        self._spline = CubicHermiteSpline(places, values, slopes)
        low, middle, high = places
        whole = CubicHermiteSpline(places[::2], values[::2], slopes[::2])
        off = abs(whole(middle) - values[1])
        off += (high - low) / 4 * abs(whole(middle, 1) - slopes[1])
        u = (middle - low) / (high - low)
        self.misfit = float(off / (4 * u * (1 - u)) ** 2)

    def __call__(self, at: Any) -> Any:
        """Values at a place or at several, shape (n,)."""
        return self._spline(at)

    def error(self, at: Any) -> Any:
        """Bounds on the errors there."""
        low, middle, high = self._places
        u = np.where(at <= middle, (at - low) / (middle - low), (at - middle) / (high - middle))
        return self.misfit * (4 * u * (1 - u)) ** 2 + self._noise


@dataclass(frozen=True)
class Unit:
    """A mode, whose z is ``mean``, or a pair with m and s; and how many modes are the same."""

    window: Window
    mean: Hermite
    half: Hermite | None
    copies: int

    def members(self, at: Any) -> Complexes:
        """The z of its modes at a place, shape (1 or 2,), or at several, shape (1 or 2, n)."""
        mean = np.asarray(self.mean(at), complex)
        if self.half is None:
            return mean[None]
        root = np.sqrt(np.asarray(self.half(at), complex))
        return np.stack([mean + root, mean - root])

    def doubts(self, at: Any) -> Any:
        """Bounds on the errors of lambda of its modes (1/s)."""
        error = self.mean.error(at)
        if self.half is not None:
            root, own = np.sqrt(np.abs(self.half(at))), self.half.error(at)
            error = error + np.minimum(np.sqrt(own), own / np.maximum(2 * root, _TINY))
        least = np.abs(self.members(at)).min(axis=0).astype(complex)
        return self.window.doubts(least, error)


def units_of(window: Window, samples: Sequence[Sample]) -> list[Unit]:
    """Modes and pairs between three samples at rising values; UnresolvedError if not told apart."""
    samples = _chained(window, samples)
    if not len(samples[0].z):
        return []
    samples, copies = _without_copies(samples)
    z = np.array([each.z for each in samples])
    partner = _partners(window, samples)
    units = []
    for one, other in enumerate(partner):
        members = np.array([one] if other < 0 else sorted({one, int(other)}))
        if members[0] != one or window.far(z[:, members], _FAR).all():
            continue
        own = [each[members] for each in samples]
        unit = _unit(window, own, int(copies[members].min()))
        others = np.delete(z[1], members)
        gap = np.abs(others[:, None] - z[1, members]).min(initial=np.inf)
        if not unit.mean.misfit <= _APART * gap:
            raise UnresolvedError
        units.append(unit)
    return units


def _chained(window: Window, samples: Sequence[Sample]) -> list[Sample]:
    """The samples with modes that continue each other at the same places."""
    first, last = _matched(*samples[:2]), _matched(*samples[1:])
    following = dict(last.tolist())
    rows = [(i, j, following[j]) for i, j in first.tolist() if j in following]
    chains = np.array(rows, dtype=np.int64).reshape(-1, 3).T
    for sample, chain in zip(samples, chains, strict=True):
        alone = np.setdiff1d(np.arange(len(sample.z)), chain)
        if not window.far(sample.z[alone], BEYOND).all():
            raise UnresolvedError
    return [sample[chain] for sample, chain in zip(samples, chains, strict=True)]


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


def _without_copies(samples: Sequence[Sample]) -> tuple[list[Sample], Ints]:
    """Modes that stay together at all samples once, and how many each stands for."""
    z = np.stack([each.z for each in samples], axis=1)
    near = np.abs(z[:, None] - z[None]) <= _COPIES * np.abs(z)[:, None]
    kept, copies = np.unique(near.all(axis=2).argmax(axis=1), return_counts=True)
    return [each[kept] for each in samples], copies


def _partners(window: Window, samples: Sequence[Sample]) -> Ints:
    """The partner of each mode, -1 of single ones; UnresolvedError when one has two."""
    places = np.array([each.value for each in samples])
    z, slopes = (np.array([getattr(each, name) for each in samples]) for name in ("z", "slopes"))
    half = (z[:, :, None] - z[:, None]) / 2
    with np.errstate(invalid="ignore"):
        slope = half * (slopes[:, :, None] - slopes[:, None])
    slope[~np.isfinite(slope)] = 0.0  # of modes that have no interpolant
    square = CubicHermiteSpline(places, half**2, slope)
    distances = np.abs(square(grid_of(places)))
    near = distances.min(axis=0) <= _PARTNERS**2 * distances.max(axis=0)
    if not window.damped:
        mirrored = np.abs(z[:, :, None] - z[:, None].conj()) <= _CONJUGATES * np.abs(z)[:, :, None]
        near |= (mirrored & (z.imag != 0)[:, :, None]).any(axis=0)
    np.fill_diagonal(near, False)
    far = window.far(z, _FAR).all(axis=0)
    near &= ~(far[:, None] & far)
    if (near.sum(axis=1) > 1).any():
        raise UnresolvedError
    return np.where(near.any(axis=1), near.argmax(axis=1), -1)


def _unit(window: Window, samples: Sequence[Sample], copies: int) -> Unit:
    """A mode or a pair of samples that hold nothing else."""
    places = np.array([each.value for each in samples])
    z, slopes = (np.array([getattr(each, name) for each in samples]) for name in ("z", "slopes"))
    errors = np.array([each.errors for each in samples])
    if z.shape[1] == 1:
        if not window.damped and not z.imag.any():
            z, slopes = z.real, slopes.real
        mean = Hermite(places, z[:, 0], slopes[:, 0], float(errors.max()))
        return Unit(window, mean, None, copies)
    half, error = (z[:, 0] - z[:, 1]) / 2, errors.max(axis=1)
    with np.errstate(invalid="ignore"):
        told = [z.mean(axis=1), slopes.mean(axis=1), half**2, half * (slopes[:, 0] - slopes[:, 1])]
    if not window.damped:
        told = [each.real for each in told]
    together = np.array([each.clusters[0] == each.clusters[1] for each in samples])
    means = np.array([each.means.max() for each in samples])
    of_mean = np.where(together, means, _ROUNDING * np.abs(z).max(axis=1)).max()
    of_half = error_of_half(np.abs(half), error, together=together).max()
    mean = Hermite(places, told[0], told[1], float(of_mean))
    return Unit(window, mean, Hermite(places, told[2], told[3], float(of_half)), copies)


def grid_of(places: Sequence[float] | Floats) -> Floats:
    """Points between three places at which signs are looked at."""
    low, middle, high = places
    return np.concatenate([np.linspace(low, middle, GRID), np.linspace(middle, high, GRID)[1:]])


def error_of_half(distance: Any, error: Any, *, together: Any) -> Any:
    """Error of s of a pair from half the distance and the larger error of its members.

    Where both are judged together Elsner's bound of a member is the root of that of s.
    """
    return np.where(together, error**2, (2 * distance + error) * error)
