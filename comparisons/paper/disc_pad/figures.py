"""Figures 6, 13, 14 and 15: stability diagrams of disc and pad."""

from math import inf

from cea.contact.formulations import GaussPointToSurface, Greville, Grid
from comparisons.paper.disc_pad.case import CeaCase
from comparisons.paper.disc_pad.measures import (
    alone,
    distance,
    growth_difference,
    growth_ratio,
    motion,
    points_ratio,
    share_in_both,
    share_in_frequency,
    shift,
)
from comparisons.paper.disc_pad.stability_diagram import (
    Measure,
    Panel,
    StabilityFigure,
    at_stiffness,
)

LOW = 1e9
"""Contact stiffness at which the paper tells formulations apart (N/m)."""
MIDDLE, HIGH = 1e12, 1e14
"""Contact stiffnesses at which the paper finds them identical, and nearly so (N/m)."""
BELOW_10_KHZ = (0.0, 10e3)
BELOW_13_KHZ = (0.0, 13e3)
ABOVE_13_KHZ = (13e3, inf)

GPTS = CeaCase(GaussPointToSurface(5), LOW)
LUMPED = CeaCase(GaussPointToSurface(5, lumped=True), LOW)
COLLOCATION = CeaCase(Greville(), LOW)
FINER_RULE = CeaCase(GaussPointToSurface(15), LOW)
HIGHER_DEGREES = tuple(
    CeaCase(GaussPointToSurface(degree + 3), LOW, degree=degree) for degree in (3, 4, 5)
)
GRID = CeaCase(Grid(10), LOW)

REMARK = (
    "Modes are unstable when they grow by more than 10 1/s. Shares are of the unstable modes of "
    "either run; shifts are of all modes that were paired, means where modes nearly coalesce."
)


def differences(panel: int, case: int, what: str, paper: str | None = None) -> tuple[Measure, ...]:
    """What tells a case from the reference of its panel."""
    return (
        Measure(
            f"{what}: unstable modes that coincide in frequency within 1 %",
            panel,
            case,
            share_in_frequency,
        ),
        Measure(f"{what}: and in growth within 1 %", panel, case, share_in_both, paper),
        Measure(f"{what}: largest shift of a frequency", panel, case, shift()),
        Measure(
            f"{what}: largest difference of growth rates",
            panel,
            case,
            growth_difference,
            None,
            "1/s",
        ),
        Measure(f"{what}: modes without partner", panel, case, alone),
    )


def _figure_13() -> StabilityFigure:
    stiffnesses = {LOW: "P = 10⁹", MIDDLE: "P = 10¹²", HIGH: "P = 10¹⁴"}
    words = ("do not coincide", "identical", "largely identical")
    measures: list[Measure] = []
    for i, (P, said) in enumerate(zip(stiffnesses.values(), words, strict=True)):
        paper = "above 1" if i == 0 else None
        measures += [
            Measure(
                f"{P}: growth below 10 kHz, collocation over GPTS",
                i,
                1,
                growth_ratio(BELOW_10_KHZ),
                paper,
            ),
            Measure(
                f"{P}: growth below 15.5 kHz, collocation over GPTS", i, 1, growth_ratio((0.0, inf))
            ),
            Measure(f"{P}: largest distance of eigenvalues", i, 1, distance),
            *differences(i, 1, P, said),
        ]
    return StabilityFigure(
        "13",
        "Figure 13: collocation at Greville points and GPTS",
        tuple(
            Panel(title, tuple(c for case in (GPTS, COLLOCATION) for c in at_stiffness(case, P)))
            for P, title in stiffnesses.items()
        ),
        tuple(measures),
        REMARK + " Lagrange elements are collocated at the nodes of the pad.",
    )


FIGURE_6 = StabilityFigure(
    "6",
    "Figure 6: GPTS with and without lumping, P = 10⁹",
    (Panel("P = 10⁹", (GPTS, LUMPED)),),
    (
        *differences(0, 1, "lumped", "largely do not coincide"),
        Measure("growth below 15.5 kHz, lumped over plain", 0, 1, growth_ratio((0.0, inf))),
        Measure(
            "motion of the disc in the contact, lumped over plain",
            0,
            1,
            motion("contact_motion"),
            "below 1",
        ),
        Measure("gap, lumped over plain", 0, 1, motion("contact_gap"), "below 1"),
    ),
    REMARK + " Motion is along the normal, relative to that elsewhere on the disc, the gap "
    "relative to the motion; medians over all modes.",
)

FIGURE_13 = _figure_13()

FIGURE_14 = StabilityFigure(
    "14",
    "Figure 14: more Gauss points and a higher degree, P = 10⁹",
    (Panel("P = 10⁹", (GPTS, FINER_RULE, *HIGHER_DEGREES)),),
    tuple(
        measure
        for case, what in (
            (1, "15 × 15 points"),
            *((i, f"degree {case.degree}") for i, case in enumerate(HIGHER_DEGREES, start=2)),
        )
        for measure in (
            Measure(
                f"{what}: largest shift of a frequency below 13 kHz",
                0,
                case,
                shift(BELOW_13_KHZ),
                "not considerable",
            ),
            Measure(f"{what}: largest shift above 13 kHz", 0, case, shift(ABOVE_13_KHZ), "small"),
            Measure(
                f"{what}: largest difference of growth rates",
                0,
                case,
                growth_difference,
                "not considerable",
                "1/s",
            ),
            Measure(
                f"{what}: growth below 15.5 kHz over that of degree 2 and 5 × 5 points",
                0,
                case,
                growth_ratio((0.0, inf)),
            ),
        )
    ),
    REMARK + " NURBS gain continuity with the degree and keep their spans to degree 3, then spans "
    "grow with it; Lagrange elements, which stop at degree 4, always do, so that dofs stay about "
    "the same.",
)

FIGURE_15 = StabilityFigure(
    "15",
    "Figure 15: 104 Greville points and a grid of 10 × 10, P = 10⁹",
    (Panel("P = 10⁹", (COLLOCATION, GRID)),),
    (
        *differences(0, 1, "grid", "different"),
        Measure("growth below 15.5 kHz, grid over Greville", 0, 1, growth_ratio((0.0, inf))),
        Measure("points, grid over Greville", 0, 1, points_ratio, 100 / 104),
    ),
    REMARK + " A grid of Lagrange elements has 4 × 4 points on every facet, of which edges and "
    "corners are shared; with 3 × 3 it would be the nodes.",
)


DIAGRAMS = (FIGURE_6, FIGURE_13, FIGURE_14, FIGURE_15)
"""Stability diagrams of the paper."""
