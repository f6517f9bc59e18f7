"""Numbers that tell one spectrum from another: coinciding modes, sums of growth, shifts.

Each takes plain data of :mod:`comparisons.paper.disc_pad.stability_diagram`: a case, or the match
of a case with its reference, in which eigenvalues are pairs of the case's and the reference's.
"""

from collections.abc import Callable, Iterable
from math import inf, tau
from statistics import mean, median
from typing import Any

from comparisons.paper.common.figure import Data

WITHIN = 0.01
"""Relative difference below which modes coincide."""


def growth_sum(case: Data, band: tuple[float, float] = (0.0, inf)) -> float:
    """Sum of the growth rates (1/s) of unstable modes in a band of frequencies (Hz)."""
    return sum(m["growth"] for m in case["unstable"] if band[0] <= m["frequency"] < band[1])


def coinciding(match: Data, *, growth: bool = False) -> float:
    """Part of the unstable modes that coincide within 1 per cent.

    Parameters
    ----------
    match
        Match of a case with its reference.
    growth
        Whether growth rates must coincide too, beside frequencies.
    """
    total = len(match["unstable"]) + match["only_first"] + match["only_second"]
    if not total:
        return 1.0
    agreed = 0
    for pair in match["unstable"]:
        (growth_1, omega_1), (growth_2, omega_2) = pair["lambda"]
        near = abs(omega_1 - omega_2) <= WITHIN * omega_2
        agreed += near and (not growth or abs(growth_1 - growth_2) <= WITHIN * abs(growth_2))
    return agreed / total


def largest_shift(match: Data, band: tuple[float, float] = (0.0, inf)) -> float:
    """Largest relative difference of frequencies in a band (Hz) of the reference; 0 in none."""
    return max(_shifts(match, band), default=0.0)


def _shifts(match: Data, band: tuple[float, float]) -> Iterable[float]:
    for (_, omega), (_, reference) in _pairs(match["groups"]):
        if band[0] <= reference / tau < band[1]:
            yield abs(omega / reference - 1)


def largest_growth_difference(match: Data) -> float:
    """Largest difference of growth rates of unstable modes that were paired (1/s)."""
    return max((abs(one - other) for (one, _), (other, _) in _pairs(match["unstable"])), default=0)


def largest_distance(match: Data) -> float:
    """Largest distance of eigenvalues relative to the reference; means where they nearly meet."""
    return max(
        (
            abs(complex(*value) - complex(*reference)) / abs(complex(*reference))
            for value, reference in _pairs(match["groups"])
        ),
        default=0.0,
    )


def motion_ratio(reference: Data, case: Data, match: Data, what: str) -> float:
    """Median over paired modes of a case's part of motion over the reference's.

    Modes in which the disc moves in its plane only have no part, and do not count.

    Parameters
    ----------
    reference, case, match
        Data of both runs and of their match.
    what
        ``contact_motion``, normal motion of the disc in the contact relative to elsewhere; or
        ``contact_gap``, the gap relative to the motion of the disc.
    """
    pairs = (group["modes"] for group in match["groups"])
    parts = (
        ([case[what][i] for i in ours], [reference[what][j] for j in theirs])
        for ours, theirs in pairs
    )
    return median(
        mean(ours) / mean(theirs) for ours, theirs in parts if None not in (*ours, *theirs)
    )


def unpaired(match: Data) -> int:
    """Modes of either run, stable ones too, that stand for none of the other."""
    return sum(match["unpaired"])


def _pairs(groups: Iterable[Data]) -> Iterable[Any]:
    return (group["lambda"] for group in groups)


def share_in_frequency(reference: Data, case: Data, match: Data) -> float:
    """Part of the unstable modes whose frequencies coincide within 1 per cent."""
    return coinciding(match)


def share_in_both(reference: Data, case: Data, match: Data) -> float:
    """Part of the unstable modes whose frequencies and growth coincide within 1 per cent."""
    return coinciding(match, growth=True)


def growth_ratio(band: tuple[float, float]) -> Callable[[Data, Data, Data], float]:
    """Sum of growth rates in a band of frequencies (Hz), over that of the reference."""

    def ratio(reference: Data, case: Data, match: Data) -> float:
        below = growth_sum(reference, band)
        return growth_sum(case, band) / below if below else inf

    return ratio


def shift(band: tuple[float, float] = (0.0, inf)) -> Callable[[Data, Data, Data], float]:
    """Largest relative shift of a frequency in a band (Hz)."""
    return lambda reference, case, match: largest_shift(match, band)


def distance(reference: Data, case: Data, match: Data) -> float:
    """Largest relative distance of eigenvalues."""
    return largest_distance(match)


def growth_difference(reference: Data, case: Data, match: Data) -> float:
    """Largest difference of growth rates (1/s); unstable modes without a partner lose theirs."""
    alone = _growth_alone(case, match, 0) + _growth_alone(reference, match, 1)
    return max([largest_growth_difference(match), *alone])


def _growth_alone(run: Data, match: Data, side: int) -> list[float]:
    """Growth rates (1/s) of the unstable modes of the first or second run without a partner."""
    paired = {i for group in match["unstable"] for i in group["modes"][side]}
    return [mode["growth"] for i, mode in enumerate(run["unstable"]) if i not in paired]


def motion(what: str) -> Callable[[Data, Data, Data], float]:
    """A part of motion over that of the reference, median of paired modes."""
    return lambda reference, case, match: motion_ratio(reference, case, match, what)


def alone(reference: Data, case: Data, match: Data) -> float:
    """Modes without a partner."""
    return unpaired(match)


def search_ratio(reference: Data, case: Data, match: Data) -> float:
    """Seconds spent on making points and finding them on the other side, over the reference's."""
    return float(case["timings"]["search"] / reference["timings"]["search"])


def points_ratio(reference: Data, case: Data, match: Data) -> float:
    """Contact points, over those of the reference."""
    return case["points"] / reference["points"]
