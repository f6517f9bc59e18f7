"""Rows of a map: all values along its first axis at one value of each other."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.classify import GROWING, WORDS
from cea.reduced.branches import Branches
from cea.reduced.crossings import Threshold
from cea.reduced.model_line import ModelLine
from cea.reduced.rows import Line, in_parts
from cea.reduced.small import SmallPencil
from cea.reduced.spectrum import ReducedSpectrum
from cea.reduced.thresholds import Unresolved, thresholds_along
from cea.reduced.words import words_of
from comparisons.sweep.mapped import Mapped

UNSTABLE = WORDS.index("unstable")
"""The word as a number: its place in :data:`cea.eigen.classify.WORDS`."""
HINT = 1.05
"""Frequency, relative to the window's end, up to which growing modes above it are told."""


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
    above_growth, above_frequency
        Growth (1/s) and frequency (Hz) of the fastest mode that surely grows just above the
        window's end, shape (values,); NaN where none does.
    thresholds
        Where the number of growing modes changes.
    unresolved
        Intervals without an answer.
    resolution
        Width of the widest interval that was not looked into further.
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
    above_growth: Floats
    above_frequency: Floats
    thresholds: tuple[Threshold, ...] = ()
    unresolved: tuple[Unresolved, ...] = ()
    resolution: float = 0.0

    @property
    def bound(self) -> Floats:
        """Bound on the worst mean, with what rounding makes, relative to its speed."""
        return np.fmax.reduce(np.column_stack([self.worst, self.mean_error]), axis=1)


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

    slopes = []
    for known, there, found in zip(solved_on, points, spectra, strict=True):
        window = found.window
        moved = [known.derivatives(window, there, names) for names in asked.names]
        slopes.append(np.stack(moved, axis=1))
    row = _table(spectra, numbers, slopes, asked)
    return replace(row, **_thresholds(small, asked, others, parts, tolerance))


def _thresholds(
    small: SmallPencil,
    asked: Mapped,
    others: Sequence[float],
    parts: Sequence[Line],
    tolerance: float,
) -> dict[str, Any]:
    """Thresholds along a row, and what is not resolved; values in place of logarithms."""
    axis = asked.axes[0]
    line = ModelLine(
        small,
        [],
        lambda value: asked.pencil.values(asked.point((value, *others))),
        asked.names[0],
        asked.growth_threshold or 0.0,
        tolerance,
        axis.logarithmic,
    )
    places, bases, begins = [line.place(value) for value in axis.values], [], 0
    for part in parts:
        end = begins + len(part.spectra) - 1
        low, high = sorted((places[begins], places[end]))
        bases.append((low, high, part.basis))
        begins = end
    found = thresholds_along(replace(line, bases=bases), places)
    speed = [line.speed(each.value) for each in found.thresholds]
    return {
        "thresholds": tuple(
            replace(
                each,
                value=line.value(each.value),
                error=each.error * rate,
                slope=each.slope / rate,
            )
            for each, rate in zip(found.thresholds, speed, strict=True)
        ),
        "unresolved": tuple(
            replace(each, low=line.value(each.low), high=line.value(each.high))
            for each in found.unresolved
        ),
        "resolution": found.resolution,
    }


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


def _table(
    spectra: Sequence[ReducedSpectrum],
    numbers: Sequence[Ints],
    slopes: Sequence[Complexes],
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
        *(growth_slope, frequency_slope, *_above(spectra, asked)),
    )


def _above(spectra: Sequence[ReducedSpectrum], asked: Mapped) -> tuple[Floats, Floats]:
    """Growth (1/s) and frequency (Hz) of the fastest growing mode just above the window's end."""
    growth, frequency = np.full((2, len(spectra)), np.nan)
    for i, found in enumerate(spectra):
        end = found.settings.end
        rates, words = found.eigenvalues.real, words_of(found, asked.growth_threshold)
        above = (found.eigenvalues.imag > end) & (found.eigenvalues.imag <= HINT * end)
        above &= np.isin(words, GROWING)
        if above.any():
            fastest = int(np.argmax(np.where(above, rates, -np.inf)))
            growth[i] = found.eigenvalues[fastest].real
            frequency[i] = found.eigenvalues[fastest].imag / (2 * np.pi)
    return growth, frequency
