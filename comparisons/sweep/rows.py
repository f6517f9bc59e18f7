"""Rows of a map: all values along its first axis at one value of each other."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.classify import WORDS
from cea.reduced.between import Between
from cea.reduced.branches import Branches
from cea.reduced.onsets import Onset, onset, span_of
from cea.reduced.roots import PairLostError
from cea.reduced.rows import Line, in_parts
from cea.reduced.small import SmallPencil
from cea.reduced.spectrum import ReducedSpectrum
from cea.reduced.words import words_of
from cea.reduced.zero_growth import zero_growth
from comparisons.sweep.mapped import Mapped

UNSTABLE, SLOW = WORDS.index("unstable"), WORDS.index("grows slowly")
"""Words of modes as numbers: their places in :data:`cea.eigen.classify.WORDS`."""


Start = tuple[ReducedSpectrum, Ints, int]
"""The spectrum at the first value of a row, numbers of its branches, the next that is free."""


@dataclass(frozen=True)
class Row:
    """Modes along the first axis, by rising frequency; NaN and -1 where there are fewer.

    Parameters
    ----------
    growth, frequency
        Growth rates (1/s) and frequencies (Hz), shape (values, modes).
    uncertainty
        Bounds on the errors of lambda (1/s), of each mode by itself, shape (values, modes).
    mean_error
        Bounds on the errors of lambda relative to its speed, where modes coalesce of their mean,
        shape (values, modes).
    branch
        Numbers of branches, shape (values, modes).
    verdict
        0 stable, 1 unstable, 2 undecided, 3 grows slowly, 4 rigid, shape (values, modes).
    worst
        What the basis makes of the worst mean, relative to its speed, shape (values,).
    growth_slope, frequency_slope
        Derivatives of growth rates (1/s) and frequencies (Hz) in the axes, in their units, shape
        (values, modes, axes).
    onsets
        Where flutter begins and ends.
    lost
        Thresholds between two values that could not be followed to where they are.
    """

    growth: Floats
    frequency: Floats
    uncertainty: Floats
    mean_error: Floats
    branch: Ints
    verdict: NDArray[np.int8]
    worst: Floats
    growth_slope: Floats
    frequency_slope: Floats
    onsets: tuple[Onset, ...]
    lost: int = 0


def map_row(
    small: SmallPencil,
    asked: Mapped,
    others: Sequence[float],
    start: Start,
    tolerance: float,
    whole: SmallPencil | None = None,
) -> Row:
    """A row of a map on a reduced model.

    Parameters
    ----------
    small
        The reduced model, or that on the basis of a band.
    asked
        What is mapped.
    others
        Values of all axes but the first.
    start
        What the row begins with.
    tolerance
        Error of lambda, relative to its speed, that local bases may make.
    whole
        The reduced model itself, for values that the former does not certify; None leaves them.
    """
    values = asked.axes[0].values

    def parameters(value: float) -> dict[str, float]:
        return asked.pencil.values(asked.point((value, *others)))

    points = [parameters(value) for value in values]
    parts = in_parts(small, points, tolerance)
    spectra, solved_on = _joined(small, parts)
    if whole is not None and whole is not small:
        for i in [i for i, found in enumerate(spectra) if found.worst > tolerance]:
            spectra[i], solved_on[i] = whole.at(points[i]), whole
    first, begun, free = start
    branches = Branches(free)
    branches.back_to(first, begun)
    numbers = [branches.follow(found) for found in spectra]

    at, begins = [], 0
    for line in parts:
        own = values[begins : begins + len(line.spectra)]
        at += [Between(small, line, own, parameters, tolerance)] * (len(own) - 1)
        begins += len(own) - 1
    seek = _crossings if small.damped else _coalescences
    onsets, lost = [], 0
    for sought in seek(at, values, spectra, numbers):
        try:
            onsets.append(sought())
        except PairLostError:
            lost += 1
    slopes = []
    for known, there, found in zip(solved_on, points, spectra, strict=True):
        window = found.window
        moved = [known.derivatives(window, there, names) for names in asked.names]
        slopes.append(np.stack(moved, axis=1))
    return replace(_table(spectra, numbers, slopes, tuple(onsets), asked), lost=lost)


def _joined(
    small: SmallPencil, parts: Sequence[Line]
) -> tuple[list[ReducedSpectrum], list[SmallPencil]]:
    """Spectra along a row, and the basis that each was solved on."""
    spectra, solved_on = list(parts[0].spectra[:1]), [small]
    for number, line in enumerate(parts):
        bases = [small if i in line.whole else line.basis for i in range(len(line.spectra))]
        if not number:
            solved_on[0] = bases[0]
        spectra += line.spectra[1:]
        solved_on += bases[1:]
    return spectra, solved_on


def _coalescences(
    at: Sequence[Between],
    values: Sequence[float],
    spectra: Sequence[ReducedSpectrum],
    _: Sequence[Ints],
) -> Iterator[Callable[[], Onset]]:
    """What seeks each threshold of an undamped pencil."""
    for still, flutters, pair in _beginnings(spectra):
        near = at[min(still, flutters)]
        yield partial(onset, near, values[still], values[flutters], span_of(pair), near.on)


def _crossings(
    at: Sequence[Between],
    values: Sequence[float],
    spectra: Sequence[ReducedSpectrum],
    numbers: Sequence[Ints],
) -> Iterator[Callable[[], Onset]]:
    """What seeks each threshold of a damped pencil: branches whose growth surely changes sign."""
    for i, (before, after) in enumerate(pairwise(spectra)):
        _, here, there = np.intersect1d(numbers[i], numbers[i + 1], return_indices=True)
        one, other = before[here], after[there]
        changes = one.eigenvalues.real * other.eigenvalues.real < 0
        for found in (one, other):
            changes &= found.inside & (np.abs(found.eigenvalues.real) > found.uncertainties)
        for mode in np.flatnonzero(changes)[:, None]:
            ends = values[i], values[i + 1]
            yield partial(zero_growth, at[i], ends, one[mode], other[mode], at[i].on)


def _beginnings(spectra: Sequence[ReducedSpectrum]) -> Iterator[tuple[int, int, Any]]:
    """Neighbours between which a pair begins or ends to flutter: where not, where, its vector."""
    pairs = [_fluttering(found) for found in spectra]
    for i in range(len(spectra) - 1):
        for there, here in ((i, i + 1), (i + 1, i)):
            for vector in pairs[here].T:
                span = span_of(vector)
                known = [np.linalg.norm(span.T @ other) for other in pairs[there].T]
                if max(known, default=0.0) < _SAME:
                    yield there, here, vector


_SAME = 0.7
"""Part of a vector of a pair in the span of the other from which on they are one."""


def _fluttering(found: ReducedSpectrum) -> Any:
    """Unit vectors of eigenvalues kappa in the window that are surely not real, one of a pair."""
    window = found.window
    chosen = window.kappa.imag > np.maximum(window.certificate.errors, _REAL * window.speeds**2)
    vectors = window.right[:, chosen]
    return vectors / np.linalg.norm(vectors, axis=0)


_REAL = 1e-9
"""Imaginary part of kappa, relative to its speed squared, up to which it is rounding."""


def _table(
    spectra: Sequence[ReducedSpectrum],
    numbers: Sequence[Ints],
    slopes: Sequence[Complexes],
    onsets: tuple[Onset, ...],
    asked: Mapped,
) -> Row:
    inside = [found.inside for found in spectra]
    shape = (len(spectra), max(int(each.sum()) for each in inside))
    growth, frequency, uncertainty, mean = (np.full(shape, np.nan) for _ in range(4))
    growth_slope, frequency_slope = np.full((2, *shape, len(asked.axes)), np.nan)
    branch, verdict = np.full(shape, -1, dtype=np.int64), np.full(shape, -1, dtype=np.int8)
    for i, (found, chosen, number) in enumerate(zip(spectra, inside, numbers, strict=True)):
        window, n = found.window, int(chosen.sum())
        growth[i, :n], frequency[i, :n] = (
            window.eigenvalues.real,
            window.eigenvalues.imag / (2 * np.pi),
        )
        growth_slope[i, :n] = slopes[i].real
        frequency_slope[i, :n] = slopes[i].imag / (2 * np.pi)
        uncertainty[i, :n] = window.uncertainties
        mean[i, :n] = window.certificate.means / (2 * window.speeds**2)
        branch[i, :n] = number[chosen]
        verdict[i, :n] = [WORDS.index(word) for word in words_of(window, asked.growth_threshold)]
    worst = np.array([found.worst for found in spectra])
    return Row(
        *(growth, frequency, uncertainty, mean, branch, verdict, worst),
        *(growth_slope, frequency_slope, onsets),
    )
