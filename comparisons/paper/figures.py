"""Table of all figures of the paper and additional studies."""

from dataclasses import replace

from cea.contact.formulations import GaussPointToSurface, Greville, Grid, Mortar, Segments
from cea.errors import require
from comparisons.paper.crowned_pad import CROWNED_PAD
from comparisons.paper.disc_pad import COLLOCATION, GPTS, GRID, HIGH, LOW, LUMPED, MIDDLE, DiscPad
from comparisons.paper.figure import Figure
from comparisons.paper.lumping import LUMPING, SHAPES
from comparisons.paper.normal_compliance import NORMAL_COMPLIANCE
from comparisons.paper.patch_test import QUADRATURE, SETTINGS, PatchTest, PatchTests
from comparisons.paper.spectra import Diagram


def _gpts(points: int, *, lumped: bool = False) -> GaussPointToSurface:
    return GaussPointToSurface(points, lumped=lumped)


_TEXT, _CAPTION = "points of the text", "points of the caption"
_EXCHANGED = (5, 3)

PATCH_TESTS = (
    PatchTests(
        "3",
        "Figure 3: GPTS with and without lumping, 25 × 25 points in a span",
        (
            PatchTest(_gpts(25)),
            PatchTest(_gpts(25, lumped=True)),
            PatchTest(_gpts(25), 1e14),
            PatchTest(_gpts(25, lumped=True), 1e14, paper="machine precision"),
        ),
        ((1, 0),),
    ),
    PatchTests(
        "7",
        "Figure 7: degree and continuity, as many points in a span as the order, P = 10⁶",
        (
            PatchTest(_gpts(3), continuity=0),
            PatchTest(_gpts(3)),
            PatchTest(_gpts(5), degree=4, continuity=3, paper="negligible"),
        ),
        ((1, 0), (2, 1)),
    ),
    PatchTests(
        "8",
        "Figure 8: more Gauss points in a span, P = 10⁶",
        tuple(PatchTest(_gpts(n)) for n in (3, 5, 8, 15, 25)),
        ((4, 0),),
    ),
    PatchTests(
        "9",
        "Figure 9: degree 4, 25 × 25 points in a span, P = 10⁶",
        (
            PatchTest(_gpts(25), degree=4, continuity=3, paper="not zero"),
            PatchTest(_gpts(5), degree=4, continuity=3),
        ),
        ((0, 1),),
    ),
    PatchTests(
        "10",
        "Figure 10: collocation and GPTS at low and high P",
        (
            PatchTest(Greville(), paper=3200.0),
            PatchTest(Grid(9), paper=1700.0),
            PatchTest(_gpts(12), paper=34.0, remark=_TEXT),
            PatchTest(_gpts(15), paper=34.0, remark=_CAPTION),
            PatchTest(_gpts(12), continuity=0, remark="not in the paper"),
            PatchTest(Greville(), 1e14, paper=1800.0),
            PatchTest(Grid(9), 1e14, paper=0.06),
            PatchTest(_gpts(12), 1e14, paper=0.01, remark=_TEXT),
            PatchTest(_gpts(15), 1e14, paper=0.01, remark=_CAPTION),
        ),
    ),
    PatchTests(
        "12",
        "Figure 12: second patch test, 5 × 5 elements on side a and 3 × 3 on side b",
        (
            PatchTest(Greville(), elements=_EXCHANGED, paper=2300.0),
            PatchTest(_gpts(15), elements=_EXCHANGED, paper=0.055),
            PatchTest(Greville(), 1e14, elements=_EXCHANGED, paper=0.16),
            PatchTest(_gpts(15), 1e14, elements=_EXCHANGED, paper=0.05),
        ),
    ),
)
"""Figures of the patch test."""

_HIGHER_DEGREES = tuple(DiscPad(_gpts(degree + 3), degree=degree) for degree in (3, 4, 5))
_NOT_CONSIDERABLE = "no considerable shift below 13 kHz, a small one above"

DIAGRAMS = (
    Diagram(
        "6",
        "Figure 6: GPTS with and without lumping, P = 10⁹",
        (GPTS, LUMPED),
        paper={(LOW, 1): "largely do not coincide; motion and gap are less"},
    ),
    Diagram(
        "13",
        "Figure 13: collocation at Greville points and GPTS",
        (GPTS, COLLOCATION),
        (LOW, MIDDLE, HIGH),
        {
            (LOW, 1): "do not coincide; more growth below 10 kHz",
            (MIDDLE, 1): "identical",
            (HIGH, 1): "largely identical",
        },
    ),
    Diagram(
        "14",
        "Figure 14: more Gauss points and a higher degree, P = 10⁹",
        (GPTS, DiscPad(_gpts(15)), *_HIGHER_DEGREES),
        paper={(LOW, number): _NOT_CONSIDERABLE for number in (1, 2, 3, 4)},
    ),
    Diagram(
        "15",
        "Figure 15: 104 Greville points and a grid of 10 × 10, P = 10⁹",
        (COLLOCATION, GRID),
        paper={(LOW, 1): "different"},
    ),
    Diagram(
        "stiff",
        "Stiff contact: penalty and saddle form, compared with mortar, which does not lock",
        (
            DiscPad(Mortar(), form="saddle"),
            COLLOCATION,
            GPTS,
            replace(COLLOCATION, form="saddle"),
            replace(GPTS, form="saddle"),
        ),
        (MIDDLE, HIGH),
    ),
    Diagram(
        "yardsticks",
        "Formulations compared with segments, the exact integral of the penalty, P = 10⁹",
        (
            DiscPad(Segments()),
            GPTS,
            DiscPad(_gpts(3)),
            DiscPad(Mortar()),
            COLLOCATION,
            replace(GPTS, full_pass=True),
            replace(COLLOCATION, full_pass=True),
        ),
    ),
    Diagram(
        "boundary",
        "The mesh of the disc at the boundary of the pad, P = 10⁹",
        tuple(
            replace(GPTS, boundary=boundary, divided=True)
            for boundary in ("refined", "traced", "ignored")
        ),
    ),
)
"""Stability diagrams of disc and pad."""

FIGURES: dict[str, Figure] = {
    figure.name: figure
    for figure in (
        NORMAL_COMPLIANCE,
        *SETTINGS,
        *PATCH_TESTS,
        QUADRATURE,
        SHAPES,
        LUMPING,
        *DIAGRAMS,
        CROWNED_PAD,
    )
}
"""Every figure by its number or name."""


def chosen(names: tuple[str, ...]) -> list[Figure]:
    """Return figures by name, all by default; unknown names are refused."""
    known = {part: name for name in FIGURES for part in name.split(" and ")}
    for name in names:
        allowed = f"one of {', '.join(known)}; or claims or all, alone"
        require(name in known, "figure", name, allowed)
    wanted = dict.fromkeys(known[name] for name in names) or FIGURES
    return [FIGURES[name] for name in wanted]
