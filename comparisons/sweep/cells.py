"""Samples in cells of neighbours, each solved on a local basis; modes are one from cell to cell.

Districts halve the samples where they are spread the most, until few are left, and cells halve
these: each district has a local basis, and each cell one more within it. The sample in the middle
of a cell tells which of its modes continue those of the nearest cell that is known, beginning in
the middle of all.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from cea.arrays import Floats, Ints
from cea.reduced.branches import pairs_of
from cea.reduced.spectrum import ReducedSpectrum

_MOST = 128
"""Samples of a cell."""
_OF_A_DISTRICT = 2048
"""Samples of a district."""
_CORNERS = 6
"""Fields up to which samples in all corners are outermost, rather than at ends alone."""


@dataclass(frozen=True)
class Cell:
    """Neighbouring samples.

    Parameters
    ----------
    samples
        Their numbers, shape (n,).
    middle
        Number of the one in their middle.
    district
        Number of the district it lies in.
    """

    samples: Ints
    middle: int
    district: int


def cells_of(spread: Floats) -> list[Cell]:
    """Cells of samples, the one that holds the middle of all first, then by distance from it.

    Parameters
    ----------
    spread
        Probabilities of the samples, shape (fields, samples).
    """
    districts = _halved(spread, np.arange(spread.shape[1]), _OF_A_DISTRICT)
    cells = [
        Cell(each, _middle_of(spread, each), number)
        for number, district in enumerate(districts)
        for each in _halved(spread, district, _MOST)
    ]
    middles = spread[:, [cell.middle for cell in cells]]
    order = np.argsort(_from(middles, np.full(len(spread), 0.5)), kind="stable")
    return [cells[i] for i in order]


def _from(points: Floats, place: Floats) -> Floats:
    return np.linalg.norm(points - place[:, None], axis=0)


def _middle_of(spread: Floats, samples: Ints) -> int:
    own = spread[:, samples]
    return int(samples[_from(own, np.median(own, axis=1)).argmin()])


def _halved(spread: Floats, samples: Ints, most: int) -> list[Ints]:
    if len(samples) <= most:
        return [samples]
    own = spread[:, samples]
    widest = own[int(np.ptp(own, axis=1).argmax())]
    order, half = np.argsort(widest, kind="stable"), len(samples) // 2
    parts = np.sort(samples[order[:half]]), np.sort(samples[order[half:]])
    return [cell for part in parts for cell in _halved(spread, part, most)]


def outermost(spread: Floats, samples: Ints) -> list[int]:
    """Those of some samples that lie in corners and at ends.

    Parameters
    ----------
    spread
        Probabilities of all samples, shape (fields, samples).
    samples
        Their numbers, shape (n,).
    """
    own, count = spread[:, samples], len(spread)
    ways = np.vstack([np.eye(count), -np.eye(count)])
    if count <= _CORNERS:
        ways = np.vstack([ways, list(product((-1.0, 1.0), repeat=count))])
    sizes = np.maximum(np.ptp(own, axis=1, keepdims=True), np.finfo(float).tiny)
    found = np.argmax(ways @ ((own - own.mean(axis=1, keepdims=True)) / sizes), axis=1)
    return sorted(set(samples[found].tolist()))


def numbered(
    spectra: Sequence[ReducedSpectrum], cells: Sequence[Cell], spread: Floats
) -> list[Ints]:
    """Numbers of the modes in the middle of each cell; those of one number continue each other.

    Parameters
    ----------
    spectra
        Spectra in the middle of each cell, their coordinates in one basis.
    cells, spread
        The cells, and the probabilities of all samples.
    """
    middles = spread[:, [cell.middle for cell in cells]]
    numbers: list[Ints] = []
    free = 0
    for i, found in enumerate(spectra):
        own = np.full(len(found), -1, dtype=np.int64)
        if i:
            known = int(_from(middles[:, :i], middles[:, i]).argmin())
            own = continued(spectra[known], numbers[known], found)
        fresh = np.flatnonzero(own < 0)
        own[fresh] = free + np.arange(len(fresh))
        free += len(fresh)
        numbers.append(own)
    return numbers


def continued(known: ReducedSpectrum, numbers: Ints, found: ReducedSpectrum) -> Ints:
    """Numbers of modes that continue known ones; -1 of those that continue none."""
    own = np.full(len(found), -1, dtype=np.int64)
    if not (len(known) and len(found)):
        return own
    for i, j in pairs_of(known, known.eigenvalues, found):
        own[j] = numbers[i]
    return own
