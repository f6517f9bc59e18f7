"""Thresholds of stability on a reduced model: where the growth rate of a branch passes zero.

With damping or rotation modes decay before they grow, and lambda is smooth in the parameter there.
The bound of lambda over the slope of its growth bounds the error of the threshold.
"""

import numpy as np

from cea.arrays import Floats
from cea.reduced.onsets import Onset
from cea.reduced.roots import OnSpan, PairLostError, Spectra, root_of, vectors_of
from cea.reduced.spectrum import ReducedSpectrum

_LEAST_PART = 0.5
"""Least part of an eigenvector in the span of those at both ends that it is taken to continue."""
_ZERO = 1e-6
"""Growth at a root, relative to that at the ends: larger, and it is a jump between branches."""


def zero_growth(
    at: Spectra,
    ends: tuple[float, float],
    before: ReducedSpectrum,
    after: ReducedSpectrum,
    on: OnSpan | None = None,
) -> Onset:
    """Where the growth rate of a branch passes zero.

    Parameters
    ----------
    at
        Spectra at values of the parameter, their coordinates in one basis.
    ends
        Values, rising or falling, near to each other.
    before, after
        The one eigenvalue of the branch at each, of growth rates of opposite signs.

    Raises
    ------
    PairLostError
        When the branch is lost on the way.
    """
    span, _ = np.linalg.qr(np.hstack([before.right, after.right]))
    here, there = complex(before.eigenvalues[0]), complex(after.eigenvalues[0])

    def followed(found: ReducedSpectrum, value: float) -> int:
        part = np.linalg.norm(span.conj().T @ found.right, axis=0)
        part /= np.linalg.norm(found.right, axis=0)
        foreseen = here + (there - here) * (value - ends[0]) / (ends[1] - ends[0])
        distance = np.where(part >= _LEAST_PART, np.abs(found.eigenvalues - foreseen), np.inf)
        if not np.isfinite(distance).any():
            raise PairLostError
        return int(np.argmin(distance))

    def growth(found: ReducedSpectrum, value: float) -> float:
        return float(found.eigenvalues[followed(found, value)].real)

    def vectors(found: ReducedSpectrum, value: float) -> Floats:
        return vectors_of(found[np.array([followed(found, value)])])

    if not growth(at(ends[0]), ends[0]) * growth(at(ends[1]), ends[1]) < 0:
        raise PairLostError
    value, slope = root_of(at, growth, ends, vectors, on)
    found = at(value)
    mode = followed(found, value)
    root = complex(found.eigenvalues[mode])
    doubt = float(found.uncertainties[mode])
    if abs(root.real) > doubt + _ZERO * max(abs(here.real), abs(there.real)):
        raise PairLostError
    begins = (there.real > here.real) == (ends[1] > ends[0])
    error = (doubt + abs(root.real)) / abs(slope)
    return Onset(value, error, 1j * root.imag, slope, begins=begins)
