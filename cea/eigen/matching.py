"""Matching lists of eigenvalues by distance: optimal, with multiplicities, nothing left out."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from cea.arrays import Complexes, Floats, Ints
from cea.errors import InputError

DEGENERATE = 1e-8
"""Relative distance below which eigenvalues count as one of higher multiplicity."""

_NO_GROWTH = 1e-9
"""Growth rates below this part of abs(lambda) are rounding."""
_RIGID = 1e-6
"""Eigenvalues below this part of the largest stand for a rigid motion."""


def assign(cost: Floats, limit: float | None = None) -> tuple[Ints, Ints]:
    """Pairs of rows and columns, each used once at most, of least total cost.

    Parameters
    ----------
    cost
        Cost of each pair, shape (n, m).
    limit
        Cost of leaving a row alone: no pair that costs more is made. None makes min(n, m) pairs
        at any cost.

    Returns
    -------
    tuple
        Rows, rising, and their columns.
    """
    if limit is None:
        rows, columns = linear_sum_assignment(cost)
        return rows, columns
    n, m = cost.shape
    rows, columns = linear_sum_assignment(np.hstack([cost, np.full((n, n), limit)]))
    paired = columns < m
    return rows[paired], columns[paired]


def group(values: Complexes, tolerance: float = DEGENERATE, least: float = 0.0) -> list[Ints]:
    """Groups of eigenvalues that touch: chains of neighbours closer than a relative distance.

    Parameters
    ----------
    values
        Eigenvalues, shape (n,).
    tolerance
        Distance relative to the larger of two.
    least
        Size by which smaller ones are judged: rigid motions touch.

    Returns
    -------
    list
        Indices of each group, by its first member.
    """
    if not tolerance >= 0:
        raise InputError("tolerance", tolerance, "zero or positive")
    sizes = np.maximum(np.abs(values), least)
    near = np.abs(values[:, None] - values) <= tolerance * np.maximum(sizes[:, None], sizes)
    return connected(near)


def connected(linked: NDArray[np.bool_]) -> list[Ints]:
    """Sets of indices joined by a symmetric relation, shape (n, n), by their first members."""
    if np.count_nonzero(linked) == np.count_nonzero(np.diag(linked)):
        return list(np.arange(len(linked))[:, None])
    count, label = connected_components(csr_array(linked), directed=False)
    return [np.flatnonzero(label == i) for i in range(count)]


@dataclass(frozen=True)
class SpectrumMatch:
    """Computed eigenvalues beside those they stand for.

    Parameters
    ----------
    exact
        Eigenvalues that were to be found, multiple ones as often as their multiplicity, shape (n,).
    found
        Computed partner of each; NaN where there is none, shape (n,).
    spurious
        Computed eigenvalues of the band that stand for none.
    tolerance
        Relative distance of exact eigenvalues that are compared by their mean.
    """

    exact: Complexes
    found: Complexes
    spurious: Complexes
    tolerance: float = DEGENERATE

    @property
    def missing(self) -> Complexes:
        """Exact eigenvalues that were not found."""
        return self.exact[np.isnan(self.found)]

    @property
    def complete(self) -> bool:
        """Whether each has its partner."""
        return not len(self.missing) and not len(self.spurious)

    @cached_property
    def differences(self) -> Complexes:
        """Computed less exact eigenvalue, shape (n,); NaN where none was found.

        Members of a group carry the difference of the means: near a coalescence the members lose
        half the digits of the mean.
        """
        difference = self.found - self.exact
        for members in group(self.exact, self.tolerance):
            difference[members] = difference[members].mean()
        return difference

    @property
    def errors(self) -> Floats:
        """Relative errors of lambda, shape (n,); infinite where none was found."""
        return _relative(np.abs(self.differences), np.abs(self.exact))

    @property
    def frequency_errors(self) -> Floats:
        """Errors of Im lambda relative to abs(lambda), shape (n,)."""
        return _relative(np.abs(self.differences.imag), np.abs(self.exact))

    @property
    def growth_errors(self) -> Floats:
        """Errors of Re lambda relative to the largest growth rate of the list, shape (n,).

        In a list that does not grow, relative to abs(lambda).
        """
        size = np.abs(self.exact)
        largest = np.abs(self.exact.real).max(initial=0.0)
        scale = (
            np.full(len(size), largest) if largest > _NO_GROWTH * size.max(initial=0.0) else size
        )
        return _relative(np.abs(self.differences.real), scale)


def _relative(error: Floats, scale: Floats) -> Floats:
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
    """Find the computed partner of each exact eigenvalue of a band.

    Both lists may, and near the ends of the band should, reach beyond it: what lies there is
    matched too, but neither missed nor called spurious.

    Parameters
    ----------
    computed, exact
        Eigenvalues, multiple ones as often as their multiplicity.
    band
        Lowest and highest Im lambda of the exact eigenvalues that must be found.
    reach
        Largest distance of partners relative to the exact eigenvalue.
    tolerance
        Relative distance of exact eigenvalues that are compared by their mean.
    """
    if not band[0] < band[1]:
        raise InputError("band", band, "a lowest below a highest")
    if not reach > 0:
        raise InputError("reach", reach, "positive")
    # A rigid motion has lambda = 0, found as rounding: nothing is relative to that.
    size = np.maximum(np.abs(exact), _RIGID * np.abs(exact).max(initial=1.0))
    distance = np.abs(computed[None, :] - exact[:, None]) / size[:, None]
    rows, columns = assign(distance, reach)
    found = np.full(len(exact), np.nan, complex)
    found[rows] = computed[columns]
    listed = (exact.imag >= band[0]) & (exact.imag <= band[1])
    alone = np.setdiff1d(np.arange(len(computed)), columns)
    inside = (computed[alone].imag >= band[0]) & (computed[alone].imag <= band[1])
    return SpectrumMatch(exact[listed], found[listed], computed[alone][inside], tolerance)
