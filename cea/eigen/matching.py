"""Matching eigenvalues by distance, with multiplicities."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from cea.arrays import Complexes, Floats, Ints

DEGENERATE = 1e-8
"""Relative distance below which eigenvalues count as one of higher multiplicity."""

_NO_GROWTH = 1e-9
"""Growth rate relative to abs(lambda) below which it counts as rounding."""
_RIGID = 1e-6
"""Size of an eigenvalue relative to the largest below which it counts as a rigid body mode."""


def assign(cost: Floats, limit: float | None = None) -> tuple[Ints, Ints]:
    """Return the pairs of rows (sorted) and columns with the least total cost, each used once.

    Pairs that cost more than the limit are omitted; without a limit there are min(n, m) pairs.
    """
    if limit is None:
        rows, columns = linear_sum_assignment(cost)
        return rows, columns
    n, m = cost.shape
    rows, columns = linear_sum_assignment(np.hstack([cost, np.full((n, n), limit)]))
    paired = columns < m
    return rows[paired], columns[paired]


def group(values: Complexes, tolerance: float = DEGENERATE, least: float = 0.0) -> list[Ints]:
    """Return groups of close eigenvalues, chains of near neighbours, sorted by first members.

    The tolerance is relative to the larger of two eigenvalues, and at least to ``least``, so that
    rigid body modes form one group.
    """
    sizes = np.maximum(np.abs(values), least)
    near = np.abs(values[:, None] - values) <= tolerance * np.maximum(sizes[:, None], sizes)
    return connected(near)


def connected(linked: NDArray[np.bool_]) -> list[Ints]:
    """Return connected sets of indices of a symmetric relation (n, n), sorted by first members."""
    if np.count_nonzero(linked) == np.count_nonzero(np.diag(linked)):
        return list(np.arange(len(linked))[:, None])
    count, label = connected_components(csr_array(linked), directed=False)
    return [np.flatnonzero(label == i) for i in range(count)]


@dataclass(frozen=True)
class SpectrumMatch:
    """Exact eigenvalues with their computed partners (NaN if missing), and spurious ones.

    Differences are computed minus exact; for a group of close exact eigenvalues they are the
    difference of the means: near a coalescence its members have half as many digits as the mean.
    """

    exact: Complexes
    found: Complexes
    differences: Complexes
    spurious: Complexes

    @property
    def missing(self) -> Complexes:
        """Exact eigenvalues that were not found."""
        return self.exact[np.isnan(self.found)]

    @property
    def errors(self) -> Floats:
        """Relative errors of lambda, shape (n,); infinite where none was found."""
        return _relative(self.differences, np.abs(self.exact))

    @property
    def frequency_errors(self) -> Floats:
        """Errors of Im lambda relative to abs(lambda), shape (n,)."""
        return _relative(self.differences.imag, np.abs(self.exact))

    @property
    def growth_errors(self) -> Floats:
        """Errors of Re lambda relative to the largest abs(Re lambda), or to abs(lambda), (n,).

        The latter where all Re lambda are rounding.
        """
        size = np.abs(self.exact)
        largest = np.abs(self.exact.real).max(initial=0.0)
        grows = largest > _NO_GROWTH * size.max(initial=0.0)
        return _relative(self.differences.real, np.where(grows, largest, size))


def _relative(differences: NDArray[Any], scale: Floats) -> Floats:
    error = np.abs(differences)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(error == 0, 0.0, error / scale)
    return np.where(np.isnan(error), np.inf, relative)


def match_spectrum(
    computed: Complexes,
    exact: Complexes,
    band: tuple[float, float] = (0.0, np.inf),
    *,
    reach: float = 0.5,
    tolerance: float = DEGENERATE,
) -> SpectrumMatch:
    """Find the computed partner of each exact eigenvalue whose Im lambda is in a band.

    Both lists contain eigenvalues with their multiplicity, and should extend beyond the band:
    eigenvalues outside are matched too, but count neither as missing nor as spurious. The distance
    of partners relative to the exact one is at most ``reach``; exact eigenvalues within a relative
    ``tolerance`` of each other are compared by their mean.
    """
    # Rigid body modes have lambda = 0, computed as rounding: use a least size.
    size = np.maximum(np.abs(exact), _RIGID * np.abs(exact).max(initial=1.0))
    distance = np.abs(computed[None, :] - exact[:, None]) / size[:, None]
    rows, columns = assign(distance, reach)
    found = np.full(len(exact), np.nan, complex)
    found[rows] = computed[columns]
    alone = np.delete(computed, columns)
    spurious = alone[(alone.imag >= band[0]) & (alone.imag <= band[1])]
    listed = (exact.imag >= band[0]) & (exact.imag <= band[1])
    exact, found = exact[listed], found[listed]
    differences = found - exact
    for members in group(exact, tolerance):
        differences[members] = differences[members].mean()
    return SpectrumMatch(exact, found, differences, spurious)
