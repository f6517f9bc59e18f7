"""Matching computed eigenvalues with a reference: errors, missing and spurious ones."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.matching import DEGENERATE, assign, group

_NO_GROWTH = 1e-9
"""Growth rate relative to abs(lambda) below which it counts as rounding."""
_RIGID = 1e-6
"""Size of an eigenvalue relative to the largest below which it counts as a rigid body mode."""


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
