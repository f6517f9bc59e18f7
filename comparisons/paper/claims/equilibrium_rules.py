"""What decides the claims on steady sliding: rules on the data of the crowned pad."""

from collections.abc import Callable, Iterator

from comparisons.kit.numbers import number
from comparisons.paper.claims.claim import Evidence, Judgement, Verdict
from comparisons.paper.common.families import Family
from comparisons.paper.common.figure import Data
from comparisons.paper.crowned_pad.case import COLLOCATION, EXACT, FINER, QUADRATURE, WEIGHTED
from comparisons.paper.crowned_pad.measures import distance, off
from comparisons.paper.crowned_pad.study import CROWNED_PAD

_DEPENDS = 0.01
"""Relative difference of the contact stiffness from which it depends on the scheme."""


def _off_exact(
    evidence: Evidence, family: Family, label: str, of: Callable[[Data, Data], float]
) -> list[float]:
    """A difference of a formulation from the exact integration at every load."""
    cases = evidence[CROWNED_PAD.name]["families"][family]
    return [abs(of(*pair)) for pair in zip(cases[label], cases[EXACT], strict=True)]


def equilibrium(evidence: Evidence, family: Family) -> Judgement:
    """Distance of the pressure from the exact integration, collocation over GPTS."""
    collocation, weighted, quadrature, mesh = (
        _off_exact(evidence, family, label, distance)
        for label in (COLLOCATION, WEIGHTED, QUADRATURE, FINER)
    )
    ratios = [a / b for a, b in zip(collocation, quadrature, strict=True)]
    why = ", ".join(
        f"{what} {number(100 * min(far))} to {number(100 * max(far))} %"
        for what, far in (
            ("collocation", collocation),
            ("with area weights", weighted),
            ("GPTS", quadrature),
            ("a finer mesh", mesh),
        )
    )
    return Judgement(_verdict(min(ratios) > 1, max(ratios) > 1), min(ratios), why)


def stiffness(evidence: Evidence, family: Family) -> Judgement:
    """Largest difference of the integral of p from that of the exact integration."""
    collocation, quadrature = (
        max(_off_exact(evidence, family, label, lambda a, b: off(a, b, "P")))
        for label in (COLLOCATION, QUADRATURE)
    )
    depends = [far > _DEPENDS for far in (collocation, quadrature)]
    why = f"GPTS {number(quadrature)}"
    return Judgement(_verdict(all(depends), any(depends)), max(collocation, quadrature), why)


def growth(evidence: Evidence, family: Family) -> Judgement:
    """Largest difference of the largest growth rate, collocation over GPTS."""
    largest = max(_growth_rates(evidence, family))
    collocation, quadrature, mesh = (
        max(_off_exact(evidence, family, label, lambda a, b: a["growth"] - b["growth"]))
        for label in (COLLOCATION, QUADRATURE, FINER)
    )
    why = (
        f"collocation {number(collocation)} 1/s, GPTS {number(quadrature)} 1/s, a finer mesh "
        f"{number(mesh)} 1/s; the largest growth rate is {number(largest)} 1/s"
    )
    return Judgement(_verdict(collocation > quadrature), collocation / quadrature, why)


def _growth_rates(evidence: Evidence, family: Family) -> Iterator[float]:
    for case in evidence[CROWNED_PAD.name]["families"][family][EXACT]:
        yield case["growth"]


def _verdict(holds: bool, depends: bool = False) -> Verdict:
    return "holds" if holds else "depends" if depends else "does not"
