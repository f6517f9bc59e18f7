"""Modes of many samples on a reduced model, every one with its bound and its verdict."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.eigen.classify import thresholds
from cea.reduced.pieces import Values
from cea.reduced.rows import along
from cea.reduced.small import SmallPencil
from cea.reduced.spectrum import ReducedSpectrum
from cea.reduced.words import words_of
from comparisons.sweep.cells import Cell, continued

Flags = NDArray[np.bool_]
_SMALL = 30
"""Size of a basis up to which it is not reduced again for the samples of a cell."""


@dataclass(frozen=True)
class Sampled:
    """Modes of samples, by rising frequency; NaN and -1 where there are fewer.

    Parameters
    ----------
    growth, frequency
        Growth rates (1/s) and frequencies (Hz), shape (samples, modes).
    uncertainty
        Bounds on the errors of lambda (1/s), shape (samples, modes).
    number
        Modes of one number continue each other from sample to sample, shape (samples, modes).
    grows, may_grow
        Whether a mode surely grows, and whether it may, shape (samples, modes). Of two that
        coalesced without damping, one growing as the other decays, both do.
    worst
        What the basis makes of the worst mean, relative to its speed, shape (samples,).
    bound
        Bound on the worst mean, with what rounding makes, relative to its speed, shape (samples,).
    """

    growth: Floats
    frequency: Floats
    uncertainty: Floats
    number: Ints
    grows: Flags
    may_grow: Flags
    worst: Floats
    bound: Floats


def solved(
    small: SmallPencil,
    district: SmallPencil,
    points: Sequence[Values],
    middle: tuple[ReducedSpectrum, Ints],
    tolerance: float,
    growth_threshold: float | None,
) -> Sampled:
    """Modes of the samples of one cell, in their order.

    Parameters
    ----------
    small
        The reduced model.
    district
        That on the local basis of its district.
    points
        Values of all parameters of each of its samples.
    middle
        The spectrum in its middle, and the numbers of its modes.
    tolerance
        Error of lambda, relative to its speed, that a local basis may make.
    growth_threshold
        Growth rate (1/s) above which a mode grows; None where it is relative.
    """
    spectra = along(district, points, tolerance, least=_SMALL).spectra
    if district is not small:
        pairs = zip(spectra, points, strict=True)
        spectra = [small.at(at) if found.worst > tolerance else found for found, at in pairs]
    shape = (len(spectra), max(int(found.inside.sum()) for found in spectra))
    growth, frequency, uncertainty = (np.full(shape, np.nan) for _ in range(3))
    number = np.full(shape, -1, dtype=np.int64)
    grows, may_grow = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
    for i, found in enumerate(spectra):
        inside, n = found.inside, int(found.inside.sum())
        growth[i, :n] = found.eigenvalues.real[inside]
        frequency[i, :n] = found.eigenvalues.imag[inside] / (2 * np.pi)
        uncertainty[i, :n] = found.uncertainties[inside]
        number[i, :n] = continued(*middle, found)[inside]
        for flags, sign in ((grows, -1), (may_grow, 1)):
            flags[i, :n] = _growing(found, sign, growth_threshold)[inside]
    worst, bound = (
        np.array(each) for each in zip(*((f.worst, f.bound) for f in spectra), strict=True)
    )
    return Sampled(growth, frequency, uncertainty, number, grows, may_grow, worst, bound)


def _growing(found: ReducedSpectrum, sign: int, threshold: float | None) -> Flags:
    """Which modes grow, surely (-1) or perhaps (+1), with those they coalesced with."""
    if sign < 0:
        grows = np.array([word == "unstable" for word in words_of(found, threshold)], dtype=bool)
    else:
        limit = thresholds(found.eigenvalues, threshold)
        grows = found.eigenvalues.real + found.uncertainties > limit
    if found.settings.decay < np.inf:
        return grows
    distance = np.abs(found.kappa[:, None] - found.kappa.conj())
    np.fill_diagonal(distance, np.inf)
    for mode in np.flatnonzero(grows & (found.kappa.imag != 0)):
        grows[int(np.argmin(distance[mode]))] = True
    return grows


def gathered(parts: Sequence[tuple[Cell, Sampled]]) -> Sampled:
    """Samples of all cells, in their own order."""
    order = np.concatenate([cell.samples for cell, _ in parts])
    width = max(part.growth.shape[1] for _, part in parts)
    whole = {}
    for name in (field.name for field in fields(Sampled)):
        columns = []
        for _, part in parts:
            values = getattr(part, name)
            if values.ndim == 2:
                gone = {"f": np.nan, "i": -1, "b": False}[values.dtype.kind]
                wider = ((0, 0), (0, width - values.shape[1]))
                values = np.pad(values, wider, constant_values=gone)
            columns.append(values)
        joined = np.concatenate(columns)
        whole[name] = np.empty_like(joined)
        whole[name][order] = joined
    return Sampled(**whole)
