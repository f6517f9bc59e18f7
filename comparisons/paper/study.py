"""The study of the paper: figures, numbers of its text compared with ours, and claims."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
from matplotlib.figure import Figure as Picture

from comparisons.paper import patch_test
from comparisons.paper.claims import judged
from comparisons.paper.figure import Tables
from comparisons.paper.figures import DIAGRAMS, FIGURES, PATCH_TESTS, chosen
from comparisons.study.numbers import number, shown
from comparisons.study.sections import Column, Drawing, Frame, Plot, Section, Table, diagram
from comparisons.study.study import CHOOSES, Case, Session, Study, StudyResult


@dataclass(frozen=True)
class Options:
    """Options of the study."""

    figures: Annotated[tuple[str, ...], "Numbers of figures, or names of additional studies."] = (
        field(default=(), metadata=CHOOSES)
    )


def cases(options: Options) -> Iterator[Case]:
    """Every figure on every kind of mesh."""
    for figure in chosen(options.figures):
        for mesh in figure.meshes:
            yield {"figure": figure.name, "mesh": mesh}


def inputs(case: Case, options: Options) -> Mapping[str, Any]:
    """Return everything that determines a case."""
    return FIGURES[case["figure"]].inputs(case["mesh"])


def evaluate(case: Case, session: Session) -> Tables:
    """Return the rows of a figure."""
    return FIGURES[case["figure"]].evaluate(case["mesh"], session)


def _melted(result: StudyResult) -> pd.DataFrame:
    """Lines of Figure 5 with one row for each point of disc or pad."""
    frame = result.frame("lines")
    if frame.empty:
        return frame
    return frame.melt(["mesh", "run", "arc"], ["disc", "pad"], "body", "u").dropna()


def _drawings() -> Iterator[Drawing]:
    """Yield the pictures of the figures of the patch test, one for each kind of mesh."""
    for figure in PATCH_TESTS:
        for mesh in figure.meshes:

            def drawing(result: StudyResult, of: Any = figure, on: Any = mesh) -> Picture | None:
                labels = {"figure": of.name, "mesh": on}
                made = any(case["labels"] == labels for case in result.cases)
                return patch_test.drawn(of, on, result) if made else None

            drawing.__name__ = f"figure_{figure.name}_{mesh}"
            drawing.__doc__ = f"{figure.title}, {mesh}."
            yield drawing


def headline(result: StudyResult) -> str | None:
    """State how many claims hold on every kind of mesh, and on none."""
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
    "arc": Column("position on the line", "m", shown(3)),
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
    """Return a plot with the title of its figure."""
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
        "Claims of the paper, and whether they hold in the figures on each kind of mesh.",
        headline,
        [_table("claims", "Claims.", frame=judged, printed=True)],
    ),
    Section(
        "Numbers of the paper",
        "Numbers of the paper are for NURBS. The paper draws the law of Figure 1 without numbers. "
        "It does not state the elements of Figure 2, and shows those of Figure 11 in a picture "
        "only.",
        tables=[_table("numbers", "Numbers of the paper and ours.", printed=True)],
        plots=[_plot("1", "law", "closure", "pressure", "curve", name="figure_1")],
    ),
    Section(
        "Contact patch test",
        "Oscillation: largest minus smallest normal stress over the interface. The 34 N/m² of "
        "Figure 10 are not reproduced with D2C1: side a oscillates by 0.034 N/m² with 15 × 15 "
        "points (perhaps an error of units in the paper), and D2C0 with 12 × 12 points comes near. "
        "No pair of uniform meshes of 2 to 8 elements a side gives all four oscillations of "
        "Figure 12.",
        tables=[_table("patch_tests", "Every run.", printed=True)],
        plots=[*_drawings()],
    ),
    Section(
        "Gauss points",
        "With the continuity c the error falls like n^-(c + 2); the numbers list fitted slopes.",
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
            )
        ],
    ),
    Section(
        "Lumping",
        "Figures 4 and 5 show, of the modes common to both runs, the one with the largest normal "
        "motion of the disc in the contact. Rotation: contact energy of a rotation of both bodies "
        "about a horizontal axis, which should be zero, over that of the pad alone. The part "
        "explained is 1 - |shift - false shift|² / |shift|² over all modes.",
        tables=[
            _table("lumping", "False stiffness, and the part it explains.", printed=True),
            _table("lumping_shifts", "Relative shifts of all modes.", shown=False),
            _table("lines", "Lines of Figure 5.", shown=False),
        ],
        plots=[
            Plot("figure_5", _FIGURE_5, _melted, "arc", "u", ("body",), ("mesh", "run"), "", OWN),
            _plot("lumping", "lumping_shifts", "false_shift", "shift", "mesh", style="markers"),
        ],
        modes=True,
    ),
    Section(
        "Disc and pad",
        "Modes are unstable if they grow by more than 10 1/s. Shares are of the unstable modes of "
        "both runs; shifts are of all matched modes, or their means where modes nearly coalesce. "
        "Motion is normal motion of the disc in the contact over that elsewhere, the gap is "
        "relative to that motion; both are medians over modes. Elements are enlarged with the "
        "degree: NURBS beyond degree 3, Lagrange elements (up to degree 4) always. Unstructured "
        "tetrahedra cannot trace the pad: the study of its boundary uses hexahedra divided into "
        "six.",
        tables=[
            _table("measures", "Cases compared with the reference of their diagram.", printed=True),
            _table("runs", "Every run."),
            _table("modes", "Modes of every run.", shown=False),
            _table("matches", "Modes matched with the reference.", shown=False),
        ],
        plots=[
            diagram(f"figure_{name}", f"{title}.", frame, ("case",), panel=("mesh", "P"), own=OWN)
            for name, title, frame in _MODES
        ],
    ),
    Section(
        "Steady sliding",
        "Each formulation with its own steady state, compared with exact integration (segments) on "
        "the same mesh: contact pressure at 9 × 60 points of the pad in the mean square, and P, "
        "the integral of p. Tetrahedra are hexahedra divided into six.",
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
    title="Figures and claims of Mohanasundaram, Shimoyama, Gillot and Besset (2023)",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    sections=SECTIONS,
    scene=inputs,
    quick={"figures": ("1", "2", "7", "4", "lumping", "6", "13", "crowned")},
    shipped=Path(__file__).with_name("results"),
)
