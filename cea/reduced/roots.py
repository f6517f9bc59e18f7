"""Roots of what one pair or one branch does along a parameter, by few whole spectra.

The eigenvectors at both ends of an interval are a basis of a dozen vectors, on which a root is
sought. The whole spectrum is made where that root is; the vectors there make the dozen better, and
so on until the root stays. With residuals of both sides it moves by their product each time, so
that two or three spectra do where a bracket on whole spectra takes twenty.
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from cea.arrays import Floats
from cea.reduced.small import columns_of
from cea.reduced.spectrum import ReducedSpectrum

Spectra = Callable[[float], ReducedSpectrum]
"""Spectra at values of a parameter."""
OnSpan = Callable[[Floats], Spectra]
"""Makes spectra on the span of some vectors."""
Followed = Callable[[ReducedSpectrum, float], float]
"""What has a root, of a spectrum and the value that it is at."""

_SAME = 1e-6
"""Step, relative to the interval, after which the next, of its square, is as good as none."""
_ROUNDS = 6
"""Times that vectors are taken in before whole spectra are bracketed."""
_NEAR = 1e-3
"""Part of an interval about a root that is known within which it is sought once more."""


class PairLostError(Exception):
    """No two eigenvalues continue a pair, or none a branch."""


def root_of(
    at: Spectra,
    function: Followed,
    ends: tuple[float, float],
    vectors: Callable[[ReducedSpectrum, float], Floats],
    on: OnSpan | None,
) -> tuple[float, float]:
    """A root between two values at which a function has opposite signs, and its slope there.

    Parameters
    ----------
    at
        Spectra, their coordinates in one basis.
    function
        The function.
    ends
        The two values.
    vectors
        The vectors of what is followed in a spectrum, shape (k, columns).
    on
        Spectra on few vectors; None where whole ones are cheap.

    Raises
    ------
    PairLostError
        When what is followed is lost.
    """
    if on is not None:
        known, last, within = [vectors(at(end), end) for end in ends], np.inf, ends
        try:
            for _ in range(_ROUNDS):
                value, slope = _bracketed(on(np.hstack(known)), function, within)
                if abs(value - last) <= _SAME * abs(ends[1] - ends[0]):
                    return value, slope
                known.append(vectors(at(value), value))
                last, within = value, _about(value, ends)
        except PairLostError:  # what few vectors lose all may hold
            pass
    return _bracketed(at, function, ends)


def _about(value: float, ends: tuple[float, float]) -> tuple[float, float]:
    """A small interval about a value, within another and in its direction."""
    step = _NEAR * (ends[1] - ends[0])
    low, high = min(ends), max(ends)
    return min(max(value - step, low), high), min(max(value + step, low), high)


def _bracketed(at: Spectra, function: Followed, ends: tuple[float, float]) -> tuple[float, float]:
    """A root and the slope there by bracketing, and by the difference over what is left of it."""

    def of(value: float) -> float:
        return function(at(value), value)

    if not of(ends[0]) * of(ends[1]) < 0:
        raise PairLostError
    scale = max(map(abs, ends))
    value = float(brentq(of, *ends, xtol=1e-14 * scale, rtol=1e-14))
    low, high = _about(value, ends)
    return value, (of(high) - of(low)) / (high - low)


def vectors_of(found: ReducedSpectrum) -> Floats:
    """Real and imaginary parts of all right and left vectors, each of unit length."""
    return columns_of(found.right, found.left)
