"""Thresholds of flutter on a reduced model: where two eigenvalues coalesce along one parameter.

The discriminant d = (kappa_1 - kappa_2)^2 of a pair is analytic and passes through zero there
(:mod:`cea.eigen.thresholds`). Its bound, 4 e^2 with e that of the pair's members, over its slope
bounds the error of the threshold.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from cea.arrays import Floats, Ints
from cea.reduced.roots import OnSpan, PairLostError, Spectra, root_of, vectors_of
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


def onset(
    at: Spectra, still: float, flutters: float, pair: Floats, on: OnSpan | None = None
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

    def surely_flutters(found: ReducedSpectrum) -> float:
        members = _pair(found, pair)
        return _discriminant(found, members) + _doubt(found, members)

    def discriminant(found: ReducedSpectrum, _: float) -> float:
        return _discriminant(found, _pair(found, pair))

    def vectors(found: ReducedSpectrum, _: float) -> Floats:
        return vectors_of(found[_pair(found, pair)])

    ends = still, flutters
    before, after = (discriminant(at(end), end) for end in ends)
    if abs(before) <= _doubt(at(still), _pair(at(still), pair)):
        if not surely_flutters(at(flutters)) < 0:
            raise PairLostError
        scale = max(abs(still), abs(flutters))
        sure = brentq(lambda value: surely_flutters(at(value)), *ends, xtol=1e-14 * scale)
        value, slope = still, (discriminant(at(sure), sure) - before) / (sure - still)
        error = abs(sure - still)
    else:
        if not before > 0 > after:
            raise PairLostError
        value, slope = root_of(at, discriminant, ends, vectors, on)
        found = at(value)
        members = _pair(found, pair)
        doubt = 4 * float(found.certificate.errors[members].max()) ** 2
        error = (doubt + abs(_discriminant(found, members))) / abs(slope)
        if not error < abs(flutters - still):
            raise PairLostError
    found = at(value)
    members = _pair(found, pair)
    mean = found.kappa[members].mean()
    root = complex(upper_root(np.array([mean]))[0])
    return Onset(value, float(error), root, float(slope), begins=bool(flutters > still))


def span_of(vector: Floats) -> Floats:
    """Orthonormal basis of real and imaginary part of coordinates, shape (k, 2)."""
    basis, _ = np.linalg.qr(np.column_stack([vector.real, vector.imag]))
    return basis


def _pair(found: ReducedSpectrum, pair: Floats) -> Ints:
    """The two eigenvalues with the greatest parts in the span of a pair."""
    lengths = np.linalg.norm(found.right, axis=0)
    part = np.linalg.norm(pair.T @ found.right, axis=0) / lengths
    members = np.argsort(part)[-2:]
    if len(members) < 2 or part[members].min() < _LEAST_PART:
        raise PairLostError
    return members


def _discriminant(found: ReducedSpectrum, members: Ints) -> float:
    square = complex((found.kappa[members[0]] - found.kappa[members[1]]) ** 2)
    if abs(square.imag) > _SAME * abs(square):
        raise PairLostError
    return square.real


def _doubt(found: ReducedSpectrum, members: Ints) -> float:
    """Bound on the error of a discriminant (1/s^4)."""
    error = float(found.certificate.errors[members].max())
    return 4 * error * (abs(found.kappa[members[0]] - found.kappa[members[1]]) + error)
