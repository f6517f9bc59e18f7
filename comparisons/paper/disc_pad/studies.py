"""Studies beside the stability diagrams, which decide what the paper's text supposes."""

from math import inf

from cea.contact.formulations import Formulation, GaussPointToSurface, Greville, Mortar, Segments
from comparisons.paper.disc_pad.case import Boundary, CeaCase
from comparisons.paper.disc_pad.figures import COLLOCATION, GPTS, HIGH, LOW, MIDDLE, REMARK
from comparisons.paper.disc_pad.measures import (
    growth_difference,
    growth_ratio,
    points_ratio,
    search_ratio,
    shift,
)
from comparisons.paper.disc_pad.stability_diagram import (
    Measure,
    Panel,
    StabilityFigure,
    at_stiffness,
)


def _saddle(formulation: Formulation, P: float) -> CeaCase:
    return CeaCase(formulation, P, form="saddle")


_STIFF_CASES = ("collocation", "GPTS", "collocation in the saddle form", "GPTS in the saddle form")

STIFF = StabilityFigure(
    "stiff",
    "Stiff contact: penalty and saddle form beside mortar, which does not lock",
    tuple(
        Panel(
            title,
            (
                _saddle(Mortar(), P),
                *at_stiffness(COLLOCATION, P),
                *at_stiffness(GPTS, P),
                _saddle(Greville(), P),
                _saddle(GaussPointToSurface(5), P),
            ),
        )
        for P, title in ((MIDDLE, "P = 10¹²"), (HIGH, "P = 10¹⁴"))
    ),
    tuple(
        measure
        for panel, P in enumerate(("P = 10¹²", "P = 10¹⁴"))
        for case, what in enumerate(_STIFF_CASES, start=1)
        for measure in (
            Measure(f"{P}, {what}: largest shift of a frequency from mortar", panel, case, shift()),
            Measure(
                f"{P}, {what}: growth below 15.5 kHz over that of mortar",
                panel,
                case,
                growth_ratio((0.0, inf)),
            ),
        )
    ),
    "What a saddle form changes was round-off of the penalty; what is left beside mortar is how "
    "many conditions the rule puts on the gap. " + REMARK,
)

_YARDSTICK_CASES = (
    "GPTS 5 × 5",
    "GPTS 3 × 3",
    "mortar",
    "collocation",
    "GPTS, full pass",
    "collocation, full pass",
)

YARDSTICKS = StabilityFigure(
    "yardsticks",
    "Formulations beside segments, the exact integral of the penalty, P = 10⁹",
    (
        Panel(
            "P = 10⁹",
            (
                CeaCase(Segments(), LOW),
                GPTS,
                CeaCase(GaussPointToSurface(3), LOW),
                CeaCase(Mortar(), LOW),
                COLLOCATION,
                CeaCase(GaussPointToSurface(5), LOW, full_pass=True),
                CeaCase(Greville(), LOW, full_pass=True),
            ),
        ),
    ),
    tuple(
        measure
        for case, what in enumerate(_YARDSTICK_CASES, start=1)
        for measure in (
            Measure(f"{what}: largest shift of a frequency", 0, case, shift()),
            Measure(
                f"{what}: largest difference of growth rates",
                0,
                case,
                growth_difference,
                None,
                "1/s",
            ),
            Measure(
                f"{what}: growth below 15.5 kHz over that of segments",
                0,
                case,
                growth_ratio((0.0, inf)),
            ),
            Measure(f"{what}: contact points over those of segments", 0, case, points_ratio),
            Measure(
                f"{what}: seconds of the search over those of segments",
                0,
                case,
                search_ratio,
            ),
        )
    ),
    REMARK,
)

_BOUNDARIES: tuple[Boundary, ...] = ("refined", "traced", "ignored")

BOUNDARY = StabilityFigure(
    "boundary",
    "The mesh of the disc at the boundary of the pad, P = 10⁹",
    (
        Panel(
            "P = 10⁹",
            tuple(
                CeaCase(GaussPointToSurface(5), LOW, boundary=boundary, divided=True)
                for boundary in _BOUNDARIES
            ),
        ),
    ),
    tuple(
        measure
        for case, what in ((1, "traced"), (2, "ignored"))
        for measure in (
            Measure(f"{what}: largest shift of a frequency from refined", 0, case, shift()),
            Measure(
                f"{what}: largest difference of growth rates",
                0,
                case,
                growth_difference,
                None,
                "1/s",
            ),
            Measure(
                f"{what}: growth below 15.5 kHz over that of refined",
                0,
                case,
                growth_ratio((0.0, inf)),
            ),
        )
    ),
    "Tetrahedra are those of hexahedra each divided into six: unstructured ones cannot trace the "
    "pad. " + REMARK,
)

STUDIES = (STIFF, YARDSTICKS, BOUNDARY)
"""All of them."""
