"""Which eigenvalues of a map are one branch: followed by vector and by eigenvalue together.

Vectors tell branches apart where they cross. Where two coalesce their vectors become one; the
subspace of both is followed then, and the eigenvalues within it by where they were going.
"""

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import assign, group
from cea.reduced.spectrum import ReducedSpectrum

_NEAR = 0.05
"""Distance, relative to a speed, that counts as much as another vector; and the farthest step."""
_TOGETHER = 1e-2
"""Relative distance of eigenvalues whose subspace is followed."""
_PARALLEL = 1e-10
"""Square of a direction of a subspace, relative to the longest, that is rounding."""


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
            for i, j in pairs_of(self._last, self._foreseen(), found):
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

    def _foreseen(self) -> Complexes:
        """Eigenvalues (1/s) where branches were going."""
        assert self._last is not None
        last, straight = self._last.eigenvalues, np.isnan(self._before)
        return np.where(straight, last, 2 * last - np.where(straight, last, self._before))


def pairs_of(
    known: ReducedSpectrum, foreseen: Complexes, found: ReducedSpectrum
) -> list[tuple[int, int]]:
    """Which eigenvalues continue which: numbers of both.

    Parameters
    ----------
    known
        Eigenvalues at some values of the parameters.
    foreseen
        Where they are thought to be at the next (1/s), shape (n,).
    found
        Eigenvalues there, their coordinates in the same basis.
    """
    groups = group(known.eigenvalues, _TOGETHER), group(found.eigenvalues, _TOGETHER)
    likeness = np.maximum(
        _likeness(known.right, found.right, groups[1]),
        _likeness(found.right, known.right, groups[0]).T,
    )
    near = np.abs(foreseen[:, None] - found.eigenvalues) / found.speeds
    cost = 1 - likeness + np.minimum(near / _NEAR, 10.0)
    return list(zip(*(each.tolist() for each in assign(cost, 1.0 + _NEAR)), strict=True))


def _likeness(left: Complexes, right: Complexes, groups: list[Ints]) -> Floats:
    """Part of every vector that lies in the space of each group of the other side's.

    By products of all vectors, once: |Q^H x|^2 = c^H G^-1 c with c = R^H x and G = R^H R.
    """
    left, right = (each / np.linalg.norm(each, axis=0) for each in (left, right))
    products, gram = right.conj().T @ left, right.conj().T @ right
    likeness: Floats = (np.abs(products) ** 2).T.copy()
    for members in groups:
        if len(members) > 1:
            sizes, axes = np.linalg.eigh(gram[np.ix_(members, members)])
            kept = sizes > _PARALLEL * sizes[-1]
            part = axes[:, kept].conj().T @ products[members] / np.sqrt(sizes[kept])[:, None]
            likeness[:, members] = (np.abs(part) ** 2).sum(axis=0)[:, None]
    return likeness
