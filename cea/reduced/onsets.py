"""Thresholds of flutter on a reduced model: where two eigenvalues coalesce along one parameter.

The discriminant d = (kappa_1 - kappa_2)^2 of a pair is analytic and passes through zero there
(:mod:`cea.eigen.thresholds`). Its bound, 4 e^2 with e that of the pair's members, over its slope
bounds the error of the threshold.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from cea.arrays import Floats, Ints
from cea.reduced.spectrum import ReducedSpectrum, upper_root

_LEAST_PART = 0.5
"""Least part of an eigenvector in the span of the pair that it is taken to continue."""
_SAME = 1e-6
"""Imaginary part of a discriminant, relative to its modulus, that is rounding."""


@dataclass(frozen=True)
class Onset:
    """A threshold: a coalescence, or with damping or rotation a growth rate that passes zero.

    Parameters
    ----------
    value
        Of the parameter.
    error
        Bound on its error.
    eigenvalue
        The common lambda (1/s).
    slope
        In the parameter, of the discriminant (1/s^4); of the growth rate (1/s) with damping.
    begins
        Whether flutter begins there as the parameter rises, rather than ends.
    """

    value: float
    error: float
    eigenvalue: complex
    slope: float
    begins: bool


class PairLostError(Exception):
    """No two eigenvalues continue a pair."""


def onset(
    at: Callable[[float], ReducedSpectrum], still: float, flutters: float, pair: Floats
) -> Onset:
    """Where a pair that flutters at one value, and does not at another, coalesces.

    Parameters
    ----------
    at
        Spectra at values of the parameter, their coordinates in one basis.
    still, flutters
        The values, near to each other.
    pair
        Real orthonormal basis of the pair where it flutters, shape (k, 2).

    Returns
    -------
    Onset
        Where a pair is one at the still value already, as far as its bound tells (the doublets of
        axisymmetric bodies without friction), the threshold is that value, known to as far as the
        next from which on the pair surely flutters.

    Raises
    ------
    PairLostError
        When the pair is lost, or does not coalesce between.
    """

    def discriminant(value: float) -> float:
        return _discriminant(*_pair(at(value), pair))

    def surely_flutters(value: float) -> float:
        found, members = _pair(at(value), pair)
        return _discriminant(found, members) + _doubt(found, members)

    scale = max(abs(still), abs(flutters))
    precision = {"xtol": 1e-14 * scale, "rtol": 1e-14}
    if abs(discriminant(still)) <= _doubt(*_pair(at(still), pair)):
        if not surely_flutters(flutters) < 0:
            raise PairLostError
        value, sure = still, float(brentq(surely_flutters, still, flutters, **precision))
        slope = (discriminant(sure) - discriminant(still)) / (sure - still)
        found, members = _pair(at(value), pair)
        error = abs(sure - still)
    else:
        if not discriminant(still) > 0 > discriminant(flutters):
            raise PairLostError
        value = float(brentq(discriminant, still, flutters, **precision))
        slope = slope_between(discriminant, value, (still, flutters))
        found, members = _pair(at(value), pair)
        error = 4 * float(found.certificate.errors[members].max()) ** 2 / abs(slope)
    mean = found.kappa[members].mean()
    root = complex(upper_root(np.array([mean]))[0])
    return Onset(value, float(error), root, float(slope), begins=bool(flutters > still))


def slope_between(
    function: Callable[[float], float], value: float, ends: tuple[float, float]
) -> float:
    """Slope of a function at a value, by differences that do not leave an interval."""
    step = 1e-3 * abs(ends[1] - ends[0])
    low, high = max(value - step, min(ends)), min(value + step, max(ends))
    return (function(high) - function(low)) / (high - low)


def span_of(vector: Floats) -> Floats:
    """Orthonormal basis of real and imaginary part of coordinates, shape (k, 2)."""
    basis, _ = np.linalg.qr(np.column_stack([vector.real, vector.imag]))
    return basis


def _pair(found: ReducedSpectrum, pair: Floats) -> tuple[ReducedSpectrum, Ints]:
    """The two eigenvalues with the greatest parts in the span of a pair."""
    lengths = np.linalg.norm(found.right, axis=0)
    part = np.linalg.norm(pair.T @ found.right, axis=0) / lengths
    members = np.argsort(part)[-2:]
    if len(members) < 2 or part[members].min() < _LEAST_PART:
        raise PairLostError
    return found, members


def _discriminant(found: ReducedSpectrum, members: Ints) -> float:
    square = complex((found.kappa[members[0]] - found.kappa[members[1]]) ** 2)
    if abs(square.imag) > _SAME * abs(square):
        raise PairLostError
    return square.real


def _doubt(found: ReducedSpectrum, members: Ints) -> float:
    """Bound on the error of a discriminant (1/s^4)."""
    error = float(found.certificate.errors[members].max())
    return 4 * error * (abs(found.kappa[members[0]] - found.kappa[members[1]]) + error)
