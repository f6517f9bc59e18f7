"""Which eigenvalues of a map are one branch: followed by vector and by eigenvalue together.

Vectors tell branches apart where they cross. Where two coalesce their vectors become one; the
subspace of both is followed then, and the eigenvalues within it by where they were going.
"""

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.eigenvalue_matching import assign, group
from cea.eigen.mode_matching import subspace_assurance
from cea.reduced.spectrum import ReducedSpectrum

_NEAR = 0.05
"""Distance, relative to a speed, that counts as much as another vector; and the farthest step."""
_TOGETHER = 1e-2
"""Relative distance of eigenvalues whose subspace is followed."""


class Branches:
    """Numbers of branches from one spectrum to the next.

    Parameters
    ----------
    first
        The first number that is free.
    """

    def __init__(self, first: int = 0) -> None:
        self._last: ReducedSpectrum | None = None
        self._before: Complexes = np.empty(0, dtype=complex)
        self._numbers: Ints = np.empty(0, dtype=np.int64)
        self._next = first

    @property
    def next(self) -> int:
        """The next number that is free."""
        return self._next

    def follow(self, found: ReducedSpectrum) -> Ints:
        """Numbers of the branches of eigenvalues at the next values, shape (n,)."""
        n = len(found)
        numbers, before = np.full(n, -1, dtype=np.int64), np.full(n, np.nan + 0j)
        if self._last is not None and len(self._last) and n:
            for i, j in zip(*assign(self._cost(found), 1.0 + _NEAR), strict=True):
                numbers[j], before[j] = self._numbers[i], self._last.eigenvalues[i]
        fresh = np.flatnonzero(numbers < 0)
        numbers[fresh] = self._next + np.arange(len(fresh))
        self._next += len(fresh)
        self._last, self._before, self._numbers = found, before, numbers
        return numbers

    def back_to(self, found: ReducedSpectrum, numbers: Ints) -> None:
        """Go on from a spectrum that was followed before."""
        self._last, self._numbers = found, numbers
        self._before = np.full(len(found), np.nan + 0j)

    def _cost(self, found: ReducedSpectrum) -> Floats:
        assert self._last is not None
        last, next_ = self._last.eigenvalues, found.eigenvalues
        straight = np.isnan(self._before)
        foreseen = np.where(straight, last, 2 * last - np.where(straight, last, self._before))
        groups = group(last, _TOGETHER), group(next_, _TOGETHER)
        likeness = np.maximum(
            subspace_assurance(self._last.right, found.right, groups[1]),
            subspace_assurance(found.right, self._last.right, groups[0]).T,
        )
        near = np.abs(foreseen[:, None] - next_) / found.speeds
        return 1 - likeness + np.minimum(near / _NEAR, 10.0)
