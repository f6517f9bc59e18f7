"""Matching and interpolation of eigenvalues between three values of a parameter.

An eigenvalue is not a smooth function where it coalesces with another, but the mean of the two and
the square of half their distance,

    m = (z_1 + z_2) / 2,    s = ((z_1 - z_2) / 2)^2,

are smooth (Kato, Perturbation Theory for Linear Operators, sec. II.1). Modes are therefore treated
as single ones, or as pairs described by m and s, each with cubic Hermite interpolants of values and
slopes. z is kappa = -lambda^2 without damping and lambda with damping.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import assign
from cea.reduced.spectrum import Window

GRID = 17
"""Points in each half of an interval at which the sign of an interpolant is evaluated."""
_PARTNERS = 0.5
"""Ratio of the least to the largest distance of two modes up to which they are a pair."""
_COPIES = 1e-8
"""Relative distance up to which modes count as one multiple eigenvalue: the root of rounding."""
_APART = 0.25
"""Misfit of an interpolant relative to the distance of the next mode above which modes may be
mismatched."""
_BEYOND = 1.03
"""Frequency relative to the end of the window beyond which modes are ignored."""
_CONJUGATES = 1e-14
"""Relative distance up to which two eigenvalues count as conjugates."""
_ROUNDING = 64 * float(np.finfo(float).eps)
"""Relative rounding error of the mean of two modes."""
_TINY = float(np.finfo(float).tiny)


class UnresolvedError(Exception):
    """Three samples do not suffice; ``at`` is where a further sample would help, if known."""

    def __init__(self, at: float | None = None) -> None:
        super().__init__()
        self.at = at


@dataclass(frozen=True)
class Sample:
    """The spectrum at a value: with damping lambda of the upper half plane, otherwise kappa.

    ``z`` and their derivatives ``slopes``; error bounds of z (``errors``) and of the mean of the
    cluster of each (``means``), and numbers of clusters, shape (n,); right eigenvectors of unit
    norm in one basis for all values, shape (k, n). Stacked samples have an additional first axis.
    """

    value: float
    z: Complexes
    slopes: Complexes
    errors: Floats
    means: Floats
    clusters: Ints
    vectors: Complexes

    def __getitem__(self, modes: NDArray[Any]) -> "Sample":
        return Sample(self.value, *(each[..., modes] for each in self._arrays))

    @property
    def _arrays(self) -> tuple[NDArray[Any], ...]:
        return self.z, self.slopes, self.errors, self.means, self.clusters, self.vectors

    def with_mirror_image(self) -> "Sample":
        """Return the sample with the conjugates of its lambda appended."""
        above = self[self.z.imag > 0]
        below = replace(above, clusters=above.clusters + 1 + self.clusters.max(initial=0))
        both = zip(self._arrays, below._arrays, strict=True)
        return Sample(self.value, *(np.concatenate([a, b.conj()], axis=-1) for a, b in both))

    @classmethod
    def stacked(cls, samples: Sequence["Sample"]) -> "Sample":
        """Return several samples of the same modes as one."""
        arrays = zip(*(each._arrays for each in samples), strict=True)
        return cls(np.nan, *(np.stack(each) for each in arrays))


class Hermite:
    """Two cubics through values and slopes at three points; ``noise`` is the error of the values.

    The error of a cubic is largest in the middle of its interval. The error there of one cubic over
    the whole interval bounds that of the two cubics, which is sixteen times smaller. ``misfit`` is
    that bound without ``noise``.
    """

    def __init__(
        self, places: Floats, values: NDArray[np.inexact], slopes: NDArray[np.inexact], noise: float
    ) -> None:
        if not np.isfinite(slopes).all():
            raise UnresolvedError
        self.places, self._noise = places, noise
        self._spline = CubicHermiteSpline(places, values, slopes)
        low, middle, high = places
        whole = CubicHermiteSpline(places[::2], values[::2], slopes[::2])
        off = abs(whole(middle) - values[1])
        off += (high - low) / 4 * abs(whole(middle, 1) - slopes[1])
        u = (middle - low) / (high - low)
        self.misfit = float(off / (4 * u * (1 - u)) ** 2)

    def __call__(self, at: Any) -> Any:
        """Return the values at a point or at several, shape (n,)."""
        return self._spline(at)

    def error(self, at: Any) -> Any:
        """Return error bounds of the values at a point or at several."""
        low, middle, high = self.places
        u = np.where(at <= middle, (at - low) / (middle - low), (at - middle) / (high - middle))
        return self.misfit * (4 * u * (1 - u)) ** 2 + self._noise


@dataclass(frozen=True)
class Unit:
    """A mode with z = ``mean``, or a pair with m = ``mean`` and s = ``half``; its multiplicity."""

    window: Window
    mean: Hermite
    half: Hermite | None
    copies: int

    def members(self, at: Any) -> Complexes:
        """Return z of its modes at a point, shape (1 or 2,), or at several, shape (1 or 2, n)."""
        mean = np.asarray(self.mean(at), complex)
        if self.half is None:
            return mean[None]
        root = np.sqrt(np.asarray(self.half(at), complex))
        return np.stack([mean + root, mean - root])

    def errors(self, at: Any) -> Any:
        """Return error bounds of z of its modes."""
        error = self.mean.error(at)
        if self.half is None:
            return error
        root, own = np.sqrt(np.abs(self.half(at))), self.half.error(at)
        return error + np.minimum(np.sqrt(own), own / np.maximum(2 * root, _TINY))

    def doubts(self, at: Any) -> Any:
        """Return error bounds of lambda of its modes (1/s)."""
        least = np.abs(self.members(at)).min(axis=0).astype(complex)
        return self.window.doubts(least, self.errors(at))


def units_of(window: Window, samples: Sequence[Sample]) -> list[Unit]:
    """Return modes and pairs between three samples; UnresolvedError if they cannot be matched."""
    places = np.array([each.value for each in samples])
    chains, units = _chained(window, samples), list[Unit]()
    if not chains.z.size:
        return units
    chains, copies = _without_copies(chains)
    for one, other in enumerate(_partners(window, places, chains)):
        members = np.array([one] if other < 0 else [one, other])
        if 0 <= other < one or window.far(chains.z[:, members], _BEYOND).all():
            continue
        unit = _unit(window, places, chains[members], int(copies[members].min()))
        others = np.delete(chains.z[1], members)
        gap = np.abs(others[:, None] - chains.z[1, members]).min(initial=np.inf)
        if not unit.mean.misfit <= _APART * gap:
            raise UnresolvedError
        units.append(unit)
    return units


def _chained(window: Window, samples: Sequence[Sample]) -> Sample:
    """Return the samples restricted to modes that are matched over all of them, stacked."""
    first, last = _matched(*samples[:2]), dict(_matched(*samples[1:]).tolist())
    rows = [(i, j, last[j]) for i, j in first.tolist() if j in last]
    chains = np.array(rows, dtype=np.int64).reshape(-1, 3).T
    for sample, chain in zip(samples, chains, strict=True):
        if not window.far(np.delete(sample.z, chain), _BEYOND).all():
            raise UnresolvedError
    return Sample.stacked([sample[chain] for sample, chain in zip(samples, chains, strict=True)])


def _matched(one: Sample, other: Sample) -> Ints:
    """Return pairs of modes, matched by shape and by the trapezoidal rule for the eigenvalues."""
    step = (other.value - one.value) / 2
    moved = other.z - one.z[:, None]
    foreseen = step * (one.slopes[:, None] + other.slopes)
    size = np.abs(moved) + np.abs(step) * (np.abs(one.slopes)[:, None] + np.abs(other.slopes))
    with np.errstate(invalid="ignore"):
        misfit = np.nan_to_num(np.abs(moved - foreseen) / (size + _TINY), nan=1.0)
    likeness = np.abs(one.vectors.conj().T @ other.vectors) ** 2
    return np.stack(assign(misfit + 1 - likeness), axis=1)


def _without_copies(chains: Sample) -> tuple[Sample, Ints]:
    """Return modes that coincide at all samples as one, and their multiplicities."""
    z = chains.z.T
    near = np.abs(z[:, None] - z) <= _COPIES * np.abs(z)[:, None]
    kept, copies = np.unique(near.all(axis=2).argmax(axis=1), return_counts=True)
    return chains[kept], copies


def _partners(window: Window, places: Floats, chains: Sample) -> list[int]:
    """Return the partner of each mode, -1 for single ones; UnresolvedError when one has two."""
    z, slopes = chains.z, chains.slopes
    half = (z[:, :, None] - z[:, None]) / 2
    with np.errstate(invalid="ignore"):
        slope = half * (slopes[:, :, None] - slopes[:, None])
    slope[~np.isfinite(slope)] = 0.0  # at coalescences, where there is no interpolant
    distances = np.abs(CubicHermiteSpline(places, half**2, slope)(grid_of(places)))
    near = distances.min(axis=0) <= _PARTNERS**2 * distances.max(axis=0)
    if not window.damped:
        mirrored = np.abs(z[:, :, None] - z[:, None].conj()) <= _CONJUGATES * np.abs(z)[:, :, None]
        near |= (mirrored & (z.imag != 0)[:, :, None]).any(axis=0)
    np.fill_diagonal(near, False)
    far = window.far(z, _BEYOND).all(axis=0)
    near &= ~(far[:, None] & far)
    if (near.sum(axis=1) > 1).any():
        raise UnresolvedError
    return [int(each.argmax()) if each.any() else -1 for each in near]


def _unit(window: Window, places: Floats, own: Sample, copies: int) -> Unit:
    """Return the unit of samples that hold one mode or one pair."""
    z: NDArray[Any] = own.z
    slopes: NDArray[Any] = own.slopes
    error = own.errors.max(axis=1)
    if z.shape[1] == 1:
        if not window.damped and not z.imag.any():
            z, slopes = z.real, slopes.real
        return Unit(window, Hermite(places, z[:, 0], slopes[:, 0], error.max()), None, copies)
    half = (z[:, 0] - z[:, 1]) / 2
    with np.errstate(invalid="ignore"):
        told = z.mean(axis=1), slopes.mean(axis=1), half**2, half * (slopes[:, 0] - slopes[:, 1])
    m, dm, s, ds = told if window.damped else (each.real for each in told)
    together = own.clusters[:, 0] == own.clusters[:, 1]
    of_mean = np.where(together, own.means.max(axis=1), _ROUNDING * np.abs(z).max(axis=1))
    of_half = error_of_half(np.abs(half), error, together=together)
    mean, square = Hermite(places, m, dm, of_mean.max()), Hermite(places, s, ds, of_half.max())
    return Unit(window, mean, square, copies)


def grid_of(places: Sequence[float] | Floats) -> Floats:
    """Return the points between three samples at which signs are evaluated."""
    low, middle, high = places
    return np.concatenate([np.linspace(low, middle, GRID), np.linspace(middle, high, GRID)[1:]])


def error_of_half(distance: Any, error: Any, *, together: Any) -> Any:
    """Return the error of s of a pair from half the distance and the larger error of its members.

    For a cluster (``together``) Elsner's bound of a member is the root of the bound of s.
    """
    return np.where(together, error**2, (2 * distance + error) * error)
