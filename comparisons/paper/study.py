"""The paper's figures, each computed, stored, drawn and set beside the numbers of its text."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
from matplotlib.figure import Figure as Picture

from comparisons.paper import lumping, patch_test
from comparisons.paper.claims import judged
from comparisons.paper.figure import Figure, Tables
from comparisons.paper.figures import DIAGRAMS, FIGURES, PATCH_TESTS, chosen
from comparisons.study.numbers import number, shown
from comparisons.study.sections import Column, Drawing, Frame, Plot, Section, Table, diagram
from comparisons.study.study import CHOOSES, Case, Session, Study, StudyResult


@dataclass(frozen=True)
class Options:
    """Options of the study."""

    figures: Annotated[tuple[str, ...], "Numbers of figures, names of studies beside them."] = (
        field(default=(), metadata=CHOOSES)
    )


def cases(options: Options) -> Iterator[Case]:
    """Every figure on every kind of mesh."""
    for figure in chosen(options.figures):
        for mesh in figure.meshes:
            yield {"figure": figure.name, "mesh": mesh}


def inputs(case: Case, options: Options) -> Mapping[str, Any]:
    """Everything that determines a case."""
    return FIGURES[case["figure"]].inputs(case["mesh"])


def evaluate(case: Case, session: Session) -> Tables:
    """Rows of a figure."""
    return FIGURES[case["figure"]].evaluate(case["mesh"], session)


def _melted(result: StudyResult) -> pd.DataFrame:
    """Lines of Figure 5, those of disc and pad below each other."""
    frame = result.frame("lines")
    if frame.empty:
        return frame
    return frame.melt(["mesh", "run", "arc"], ["disc", "pad"], "body", "u").dropna()


def _drawings(draw: Any, *figures: Figure) -> Iterator[Drawing]:
    """Pictures of some figures, one for each kind of mesh."""
    for figure in figures:
        for mesh in figure.meshes:

            def drawing(result: StudyResult, of: Any = figure, on: Any = mesh) -> Picture | None:
                labels = {"figure": of.name, "mesh": on}
                made = any(case["labels"] == labels for case in result.cases)
                return draw(of, on, result) if made else None

            drawing.__name__ = f"figure_{figure.name.replace(' ', '_')}_{mesh}"
            drawing.__doc__ = f"{figure.title}, {mesh}."
            yield drawing


def headline(result: StudyResult) -> str | None:
    """How many claims hold on every kind of mesh, and on none."""
    frame = judged(result)
    if frame.empty:
        return None
    verdicts = frame.filter(like="_verdict")
    everywhere, nowhere = ((verdicts == word).all(axis=1).sum() for word in ("holds", "does not"))
    return f"{everywhere} of {len(frame)} claims hold on every kind of mesh, {nowhere} on none."


OWN = {
    "paper": Column("paper", show=lambda v: v if isinstance(v, str) else number(v)),
    "oscillation": Column("oscillation, worse side", "N/m²", shown(3)),
    "oscillation_a": Column("side a", "N/m²", shown(3)),
    "oscillation_b": Column("side b", "N/m²", shown(3)),
    "oscillation_p_gap": Column("of p g", "N/m²", shown(3)),
    "arc": Column("along the line", "m", shown(3)),
    "u": Column("normal displacement, largest of the disc 1", show=shown(3)),
    "closure": Column("closure", "m", shown(3)),
    "pressure": Column("pressure", "N/m²", shown(3)),
    "growth_difference": Column("largest difference of growth", "1/s", shown(3)),
    "load": Column("pressure on the back", "N/m²", shown(3)),
    "growth_off": Column("growth off segments", "1/s", shown(3)),
}


def _table(name: str, caption: str, **options: Any) -> Table:
    return Table(name, caption, **{"frame": name, "own": OWN} | options)


def _plot(figure: str, frame: Frame, x: str, y: str, series: str, **more: Any) -> Plot:
    """A plot with the title of its figure."""
    title = FIGURES[figure].title
    return Plot(more.pop("name", figure), title, frame, x, y, (series,), own=OWN, **more)


def _by_load(y: str, caption: str, log: str = "x") -> Plot:
    of = ("formulation",), ("mesh",)
    return Plot(f"crowned_{y}", caption, "crowned", "load", y, *of, log, OWN)


_FIGURE_5 = "Figure 5: normal displacement across the boundary of the pad."
_MODES = [
    (each.name, each.title, partial(StudyResult.frame, table="modes", figure=each.name))
    for each in DIAGRAMS
]
SECTIONS = [
    Section(
        "Claims",
        "What the paper says, and what the figures say of it on each kind of mesh.",
        headline,
        [_table("claims", "Claims.", frame=judged, printed=True)],
    ),
    Section(
        "Numbers of the paper",
        "Numbers of the paper are those of NURBS. The paper draws the law of Figure 1 without "
        "numbers; the elements of Figure 2 are not in its text, those of Figure 11 in a picture "
        "only.",
        tables=[_table("numbers", "Numbers of the paper beside ours.", printed=True)],
        plots=[_plot("1", "law", "closure", "pressure", "curve", name="figure_1")],
    ),
    Section(
        "Contact patch test",
        "Oscillation: largest less smallest normal stress over the interface. 34 N/m² of Figure 10 "
        "is not met by D2C1: side a oscillates by 0.034 N/m² with 15 × 15 points, which would be a "
        "slip of units, and D2C0 comes near with 12 × 12. No pair of uniform meshes of 2 to 8 "
        "elements a side gives all four oscillations of Figure 12.",
        tables=[_table("patch_tests", "Every run.", printed=True)],
        plots=[*_drawings(patch_test.drawn, *PATCH_TESTS)],
    ),
    Section(
        "Gauss points",
        "Lines have the slope -(c + 2), c the continuity.",
        tables=[_table("quadrature", "Errors.", shown=False)],
        plots=[
            _plot(
                "points",
                "quadrature",
                "points",
                "oscillation",
                "space",
                panel=("mesh",),
                log="xy",
                lines=patch_test.expected,
            )
        ],
    ),
    Section(
        "Lumping",
        "Figures 4 and 5 show the mode common to both runs whose disc moves most along the normal "
        "in the contact. Rotations are about a horizontal axis: energy in the contact of both "
        "bodies together, which should be none, over that of the pad alone. The part explained is "
        "1 - |shift - false shift|² / |shift|² over all modes.",
        tables=[
            _table("lumping", "What lumping adds, and what it explains.", printed=True),
            _table("lumping_shifts", "Relative shifts of all modes.", shown=False),
            _table("lines", "Lines of Figure 5.", shown=False),
        ],
        plots=[
            *_drawings(lumping.drawn, lumping.SHAPES),
            Plot("figure_5", _FIGURE_5, _melted, "arc", "u", ("body",), ("mesh", "run"), "", OWN),
            _plot("lumping", "lumping_shifts", "false_shift", "shift", "mesh", style="markers"),
        ],
    ),
    Section(
        "Disc and pad",
        "Modes are unstable when they grow by more than 10 1/s. Shares are of the unstable modes "
        "of either run, shifts are of all modes that were paired, means where modes nearly "
        "coalesce; motion of the disc is along the normal in the contact relative to elsewhere, "
        "the gap relative to the motion, medians over all modes. NURBS keep their spans to degree "
        "3, then spans grow with it; Lagrange elements, which stop at degree 4, always do. "
        "Unstructured tetrahedra cannot trace the pad: those of the study of its boundary are "
        "hexahedra divided into six.",
        tables=[
            _table("measures", "Cases beside the reference of their diagram.", printed=True),
            _table("runs", "Every run."),
            _table("modes", "modes.", shown=False),
            _table("matches", "matches.", shown=False),
        ],
        plots=[
            diagram(f"figure_{name}", f"{title}.", frame, ("case",), panel=("mesh", "P"), own=OWN)
            for name, title, frame in _MODES
        ],
    ),
    Section(
        "Steady sliding",
        "Each formulation in the state that it finds itself, beside the exact integration "
        "(segments) on the same mesh: pressure of the law at 9 × 60 points of the pad in the mean "
        "square, P the integral of p. Tetrahedra are hexahedra divided into six.",
        tables=[_table("crowned", "Every case.")],
        plots=[
            _by_load("pressure_off", "Distance of the pressure from segments.", "xy"),
            _by_load("closed", "Closed part of the pad."),
            _by_load("growth", "Largest growth rate."),
        ],
    ),
]
STUDY = Study(
    name="paper",
    title="Figures of Mohanasundaram, Shimoyama, Gillot and Besset (2023), and what they say",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    sections=SECTIONS,
    scene=inputs,
    quick={"figures": ("1", "2", "7", "points", "4", "lumping", "6", "13", "crowned")},
    shipped=Path(__file__).with_name("results"),
)
