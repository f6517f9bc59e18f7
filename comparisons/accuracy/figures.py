"""Figures of a study, drawn from its data: error against run time and dofs; growth against p."""

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from comparisons.accuracy.analysis import Line, lines, seconds_of, uses
from comparisons.accuracy.study import RULES
from comparisons.kit.numbers import number
from comparisons.kit.plots import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    GRID,
    MARKERS,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
)
from comparisons.kit.tables import Data

_COLOURS = {
    "mortar": BLACK,
    "segments": GREY,
    "gpts": BLUE,
    "gpts_lumped": VERMILION,
    "full_pass": SKY,
    "grid": GREEN,
    "node": PURPLE,
    "node_tributary": "#882255",
    "greville": ORANGE,
    "greville_area": "#A86500",
    "botella": "#B5A800",
    "botella_area": "#6B6300",
}
_BY_DEGREE = (SKY, BLUE, GREEN, ORANGE, VERMILION, "#882255")
_STYLES = {"fe": "--", "iga": "-"}


def error_against_cost(data: Data, problem: str) -> Figure:
    """Worst error of lambda against run time (above) and dofs (below); each line is a method.

    At the study's first stiffness; left every degree with the mortar method, right every contact
    rule at degree 2.
    """
    p = data["inputs"]["study"]["stiffnesses"][0]
    drawn = [ln for ln in lines(data["runs"]) if (ln.problem, ln.stiffness) == (problem, p)]
    degrees = [line for line in drawn if line.method.rule == "mortar"]
    rules = [line for line in drawn if line.method.degree == 2]
    figure = Figure(figsize=(11, 9), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 2, sharey=True, sharex="row")
    for column, (chosen, colour, title) in enumerate(
        (
            (degrees, _degree_colour, "every degree, mortar"),
            (rules, _rule_colour, "degree 2, every contact rule"),
        )
    ):
        for row, cost in enumerate((seconds_of, _dofs)):
            _errors(panels[row, column], chosen, cost, colour)
        panels[0, column].set_title(title)
        handles = [
            Line2D(
                *([], []),
                color=colour(line),
                marker=MARKERS[line.method.backend],
                linestyle=_STYLES[line.method.backend],
                label=line.method.label if column else line.method.discretisation,
            )
            for line in chosen
        ]
        panels[1, column].legend(handles=handles, fontsize=6.5, ncols=2, frameon=False)
    for axes in panels.flat:
        axes.set(xscale="log", yscale="log")  # of a panel without lines too
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(lambda value, _: number(value, 1))
        axes.xaxis.set_minor_formatter(NullFormatter())
    for axes in panels[0]:
        axes.set_xlabel("run time (s), median")
    for axes in panels[1]:
        axes.set_xlabel("dofs")
    for axes in panels[:, 0]:
        axes.set_ylabel("worst relative error of lambda")
    figure.suptitle(f"{problem}, p = {p * data['problems'][problem]['unit']:g} N/m³")
    return figure


def growth_against_stiffness(data: Data, problem: str) -> Figure:
    """Worst error of the growth rate against p, each line a contact rule at degree 2."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, 2, sharey=True)
    found = [use for use in uses(data["runs"]) if use.problem == problem and use.method.degree == 2]
    for axes, backend in zip(panels, ("fe", "iga"), strict=True):
        for rule in RULES:
            points = [
                (use.stiffness, use.error)
                for use in found
                if (use.method.backend, use.method.rule) == (backend, rule) and use.error
            ]
            if points:
                axes.loglog(
                    *zip(*points, strict=True),
                    color=_COLOURS[rule],
                    marker=MARKERS[backend],
                    markersize=4,
                    label=RULES[rule].label,
                )
        axes.set_title("FE 2" if backend == "fe" else "NURBS 2")
        axes.set_xlabel(f"p / ({data['problems'][problem]['unit']:g} N/m³)")
        axes.grid(visible=True, color=GRID)
        if axes.lines:
            axes.legend(fontsize=7, frameon=False)
    panels[0].set_ylabel("worst error of growth / largest growth")
    figure.suptitle(problem)
    return figure


def _errors(axes: Axes, chosen: Sequence[Line], cost: Any, colour: Any) -> None:
    for line in chosen:
        axes.loglog(
            [cost(run) for run in line.runs],
            line.errors(),
            _STYLES[line.method.backend],
            color=colour(line),
            marker=MARKERS[line.method.backend],
            markersize=4,
            linewidth=1.1,
        )
    axes.grid(visible=True, color=GRID)


def _dofs(run: Any) -> int:
    return int(run["dofs"])


def _degree_colour(line: Line) -> str:
    return _BY_DEGREE[line.method.degree - 1]


def _rule_colour(line: Line) -> str:
    return _COLOURS[line.method.rule]
