"""What decides the claims of the paper: one rule for each, from data to verdict.

Thresholds are stated with each claim; what the paper says in words ("largely", "identical",
"considerable") is read as: within 1 per cent, 0.1 per cent and 5 per cent of the largest growth.
"""

from collections.abc import Callable
from math import inf

import numpy as np

from comparisons.kit.numbers import number
from comparisons.paper.claims.claim import Evidence, Judgement, Verdict
from comparisons.paper.common.families import Family
from comparisons.paper.common.figure import Data
from comparisons.paper.disc_pad.figures import (
    ABOVE_13_KHZ,
    BELOW_10_KHZ,
    BELOW_13_KHZ,
    FIGURE_6,
    FIGURE_13,
    FIGURE_14,
    FIGURE_15,
)
from comparisons.paper.disc_pad.lumping import explained_part
from comparisons.paper.disc_pad.measures import (
    distance,
    growth_difference,
    growth_ratio,
    search_ratio,
    share_in_both,
    share_in_frequency,
    shift,
)
from comparisons.paper.disc_pad.stability_diagram import Measure, StabilityFigure
from comparisons.paper.disc_pad.studies import BOUNDARY, STIFF, YARDSTICKS

_CONSIDERABLE = 0.05
"""Part of the largest growth rate from which a difference of growth rates is considerable."""
_ROUNDING = 1e-10


def _measured(
    evidence: Evidence,
    figure: StabilityFigure,
    family: Family,
    place: tuple[int, int],
    of: Callable[[Data, Data, Data], float],
) -> float:
    """Measure of the case at a place, panel and number in it, of a figure."""
    value = figure.measure(evidence[figure.name], family, Measure("", *place, of))
    assert value is not None
    return float(value)


def _part_of_growth(reference: Data, case: Data, match: Data) -> float:
    """Largest difference of growth rates over the largest growth rate of the reference."""
    largest = max((mode["growth"] for mode in reference["unstable"]), default=inf)
    return growth_difference(reference, case, match) / largest


def _verdict(holds: bool, *, depends: bool = False) -> Verdict:
    return "holds" if holds else "depends" if depends else "does not"


def _patch_cases(evidence: Evidence, name: str, family: Family) -> list[Data]:
    """Cases of a figure of the patch test on a kind of mesh."""
    return [case for case in evidence[name]["cases"].values() if case["mesh"] == family]


def lumped_patch(evidence: Evidence, family: Family) -> Judgement:
    """Oscillation of lumped contact at P = 10¹⁴ against rounding."""
    cases = _patch_cases(evidence, "3", family)
    (lumped,) = (c for c in cases if "lumped" in c["rule"] and c["P"] == 1e14)
    relative = max(lumped["oscillation"].values()) / 1000.0
    return Judgement(_verdict(relative < _ROUNDING), relative)


def side_b(evidence: Evidence, family: Family) -> Judgement:
    """Oscillation of side b over side a, on meshes as they are and exchanged."""
    ratios = [
        case["oscillation"]["b"] / case["oscillation"]["a"]
        for name in ("7", "12")
        for case in _patch_cases(evidence, name, family)
        if case["P"] == 1e6
    ]
    low, high = min(ratios), max(ratios)
    return Judgement(_verdict(low > 1, depends=high > 1), low, f"largest {number(high)}")


def locks(evidence: Evidence, family: Family) -> Judgement:
    """Motion of the disc in the contact, lumped over plain, at P = 10⁶ and 10⁹."""
    low = evidence["4"]["families"][family]["motion"]
    (measure,) = (m for m in FIGURE_6.measures if m.what.startswith("motion"))
    high = FIGURE_6.measure(evidence["6"], family, measure)
    assert high is not None
    return Judgement(_verdict(low < 0.5, depends=high < 0.5), low, f"{number(high)} at P = 10⁹")


def false_stiffness(evidence: Evidence, family: Family) -> Judgement:
    """Part of the shifts by lumping that its false stiffness explains."""
    found = evidence["lumping"]["families"][family]
    part = explained_part(*(np.array(found[name]) for name in ("shifts", "false_shifts")))
    rotation = number(found["rotation"]["lumped"])
    why = f"a common rotation costs {rotation} of one of the pad alone"
    return Judgement(_verdict(part > 0.8, depends=part > 0.5), part, why)


def lumped_spectra(evidence: Evidence, family: Family) -> Judgement:
    """Share of unstable modes that coincide with and without lumping."""
    frequency = _measured(evidence, FIGURE_6, family, (0, 1), share_in_frequency)
    both = _measured(evidence, FIGURE_6, family, (0, 1), share_in_both)
    verdict = _verdict(frequency < 0.5, depends=both < 0.5)
    return Judgement(verdict, frequency, f"{number(both)} in growth too")


def overestimates(evidence: Evidence, family: Family) -> Judgement:
    """Growth below 10 kHz at P = 10⁹, collocation over GPTS."""
    ratio = _measured(evidence, FIGURE_13, family, (0, 1), growth_ratio(BELOW_10_KHZ))
    return Judgement(_verdict(ratio > 1.01), ratio)


def identical(evidence: Evidence, family: Family) -> Judgement:
    """Distance of collocation and GPTS at P = 10¹²."""
    far = _measured(evidence, FIGURE_13, family, (1, 1), distance)
    return Judgement(_verdict(far < 1e-3), far)


def worse(evidence: Evidence, family: Family) -> Judgement:
    """Distance of collocation and GPTS at P = 10¹⁴ against that at 10¹²."""
    far = [_measured(evidence, FIGURE_13, family, (panel, 1), distance) for panel in (1, 2)]
    return Judgement(_verdict(far[1] > far[0]), far[1], f"{number(far[0])} at P = 10¹²")


def _from_mortar(evidence: Evidence, family: Family, panel: int) -> list[float]:
    """Shifts from mortar: collocation, GPTS, and both in the saddle form."""
    return [_measured(evidence, STIFF, family, (panel, case), shift()) for case in (1, 2, 3, 4)]


def round_off(evidence: Evidence, family: Family) -> Judgement:
    """Shifts from mortar at P = 10¹⁴, saddle form over penalty."""
    far = _from_mortar(evidence, family, 1)
    ratio = max(far[2:]) / max(far[:2])
    return Judgement(_verdict(ratio < 0.5), ratio)


def over_constraint(evidence: Evidence, family: Family) -> Judgement:
    """Shift of GPTS from mortar at P = 10¹⁴ against that at 10¹², free of round-off."""
    middle, high = (_from_mortar(evidence, family, panel) for panel in (0, 1))
    why = f"collocation {number(high[2])}; GPTS {number(middle[3])} at P = 10¹²"
    return Judgement(_verdict(high[3] > 3 * middle[3]), high[3], why)


def more_points(evidence: Evidence, family: Family) -> Judgement:
    """Shifts and growth by more Gauss points."""
    return _insensitive(evidence, family, 1)


def higher_degree(evidence: Evidence, family: Family) -> Judgement:
    """Shifts and growth by the degree that changes growth most; those by every degree."""
    found = {
        degree: _insensitive(evidence, family, case) for degree, case in _higher_degrees(family)
    }
    worst = max(found.values(), key=lambda judged: (_RANK[judged.verdict], judged.value))
    why = "; ".join(f"degree {d}: {number(j.value)}, {j.why}" for d, j in found.items())
    return Judgement(worst.verdict, worst.value, why)


_RANK: dict[Verdict, int] = {"holds": 0, "depends": 1, "does not": 2}


def _insensitive(evidence: Evidence, family: Family, case: int) -> Judgement:
    """Shifts and growth of a case of Figure 14."""
    below = _measured(evidence, FIGURE_14, family, (0, case), shift(BELOW_13_KHZ))
    growth = _measured(evidence, FIGURE_14, family, (0, case), _part_of_growth)
    verdict = _verdict(below < 0.01 and growth < _CONSIDERABLE, depends=below < 0.01)
    return Judgement(verdict, below, f"growth differs by {number(growth)} of the largest")


def _higher_degrees(family: Family) -> list[tuple[int, int]]:
    """Degrees above 2 that a kind of mesh has, with their places in Figure 14."""
    cases = enumerate(FIGURE_14.panels[0].cases)
    return [(c.degree, place) for place, c in cases if c.degree > 2 and c.exists_on(family)]


def above_13(evidence: Evidence, family: Family) -> Judgement:
    """Shifts by higher degrees above 13 kHz over those below, least of all degrees."""
    ratios = {}
    for degree, case in _higher_degrees(family):
        below, above = (
            _measured(evidence, FIGURE_14, family, (0, case), shift(band))
            for band in (BELOW_13_KHZ, ABOVE_13_KHZ)
        )
        ratios[degree] = above / below
    low, high = min(ratios.values()), max(ratios.values())
    why = ", ".join(f"degree {degree}: {number(ratio)}" for degree, ratio in ratios.items())
    return Judgement(_verdict(low > 1, depends=high > 1), low, why)


def places(evidence: Evidence, family: Family) -> Judgement:
    """Share of unstable modes that coincide for two sets of collocation points."""
    both = _measured(evidence, FIGURE_15, family, (0, 1), share_in_both)
    frequency = _measured(evidence, FIGURE_15, family, (0, 1), share_in_frequency)
    return Judgement(_verdict(both < 0.5), both, f"{number(frequency)} in frequency alone")


def gpts(evidence: Evidence, family: Family) -> Judgement:
    """Distance of GPTS from segments, and what its search costs."""
    far = _measured(evidence, YARDSTICKS, family, (0, 1), shift())
    growth = _measured(evidence, YARDSTICKS, family, (0, 1), _part_of_growth)
    mortar = _measured(evidence, YARDSTICKS, family, (0, 3), shift())
    cost = _measured(evidence, YARDSTICKS, family, (0, 1), search_ratio)
    close = far < 1e-3 and growth < 0.01
    why = f"mortar {number(mortar)}; search takes {number(cost)} of that of segments"
    return Judgement(_verdict(close and cost < 1, depends=close), far, why)


def boundary(evidence: Evidence, family: Family) -> Judgement:
    """Growth on a mesh that ignores the boundary of the pad, and on one that traces it."""
    traced, ignored = (
        _measured(evidence, BOUNDARY, family, (0, case), _part_of_growth) for case in (1, 2)
    )
    verdict = _verdict(ignored > max(1.5 * traced, 0.01), depends=ignored > traced)
    mesh = "; hexahedra divided into six" if family == "tetrahedra" else ""
    return Judgement(verdict, ignored, f"{number(traced)} where traced{mesh}")


def full_pass(evidence: Evidence, family: Family) -> Judgement:
    """Growth of collocation against segments, full pass over half pass."""
    half, full = (
        _measured(evidence, YARDSTICKS, family, (0, case), growth_difference) for case in (4, 6)
    )
    return Judgement(_verdict(full < 0.5 * half, depends=full < half), full / half)
