"""Plots of data frames: matplotlib (PNG files) and plotly.js (pages) draw the same lines."""

from collections.abc import Iterator, Mapping, Sequence
from html import unescape
from io import BytesIO
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure

from cea.files import write_whole
from comparisons.study.columns import column
from comparisons.study.numbers import literal
from comparisons.study.sections import Plot

# Colours of Okabe and Ito, distinguishable with any colour vision.
ORANGE, SKY, GREEN = "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILION, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#8A8A8A"
BLACK, AXIS, GRID = "#222222", "#555555", "#E4E4E4"
COLOURS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, BLACK, GREY)
"""Colours of the values of a series, in their order."""
VERDICT_MARKS = {
    "unstable": ("triangle-up", VERMILION, "▲"),
    "grows slowly": ("triangle-up-open", VERMILION, "△"),
    "undecided": ("diamond", ORANGE, "◆"),
    "stable": ("circle", BLUE, "●"),
    "rigid": ("circle-open", GREY, "○"),
}
"""Marker, colour and sign of each verdict: colour is never the only difference."""
_OF_MATPLOTLIB = {
    "circle": "o",
    "square": "s",
    "triangle-up": "^",
    "diamond": "D",
    "triangle-down": "v",
    "cross": "P",
    "star": "*",
}
"""Markers of matplotlib by their names in plotly, where the suffix ``-open`` means unfilled."""
_MARKERS = tuple(_OF_MATPLOTLIB)
STYLE = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.edgecolor": AXIS,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "legend.frameon": False,
    "legend.fontsize": 8,
}
"""Style of every figure that matplotlib draws."""
_DPI = 200


Trace = dict[str, Any]
"""Trace of plotly.js, a line with its markers; ``customdata`` names the modes of points."""


def sign(verdict: str) -> str:
    """A verdict on a mode or a run, preceded by its sign if it has one."""
    return f"{VERDICT_MARKS[verdict][2]} {verdict}" if verdict in VERDICT_MARKS else verdict


def panels(plot: Plot, frame: pd.DataFrame) -> list[tuple[str, list[Trace]]]:
    """Titles of the panels of a plot, each with its lines."""
    places = {name: {v: i for i, v in enumerate(frame[name].unique())} for name in plot.series}
    named = [(name, column(name, frame, plot.own)) for name in plot.panel]
    made = []
    for values, own in _groups(frame, plot.panel):
        words = [
            f"{shown.title} = " * shown.number + shown.cell(value)
            for (_, shown), value in zip(named, values, strict=True)
        ]
        made.append((", ".join(words), list(_traces(plot, own, places))))
    return made


def _groups(frame: pd.DataFrame, keys: Sequence[str]) -> Any:
    return frame.groupby([*keys], sort=False, dropna=False) if keys else [((), frame)]


def _traces(plot: Plot, frame: pd.DataFrame, places: Mapping[str, Any]) -> Iterator[Trace]:
    for values, own in _groups(frame, plot.series):
        labels = dict(zip(plot.series, values, strict=True))
        marker, colour = _look(labels, places)
        label = ", ".join(column(n, frame, plot.own).cell(v) for n, v in labels.items())
        finite = own[[plot.x, plot.y]].replace([float("inf"), float("-inf")], float("nan"))
        finite = finite.astype(object).where(finite.notna(), None)
        trace: Trace = {"x": finite[plot.x].tolist(), "y": finite[plot.y].tolist()}
        mode = "lines+markers" if plot.style == "lines" else "markers"
        trace |= {"name": literal(label), "type": "scatter", "mode": mode}
        trace |= {"line": {"color": colour}}
        trace |= {"marker": {"color": colour, "symbol": marker, "size": 8}}
        yield trace | ({"customdata": list(own["shape"])} if "shape" in own else {})


def _look(labels: Mapping[str, Any], places: Mapping[str, Any]) -> tuple[str, str]:
    """Marker and colour of a line: the first label sets the colour, the last one the marker."""
    if "verdict" in labels:
        return VERDICT_MARKS[labels["verdict"]][:2]
    numbers = [places[name].get(value, 0) for name, value in labels.items()] or [0]
    return _MARKERS[numbers[-1] % len(_MARKERS)], COLOURS[numbers[0] % len(COLOURS)]


def draw(plot: Plot, frame: pd.DataFrame) -> Figure:
    """Draw a plot with matplotlib, panels side by side."""
    made = panels(plot, frame)
    x, y = (column(name, frame, plot.own).axis for name in (plot.x, plot.y))
    columns = min(3, len(made))
    figure = Figure(figsize=(4.4 * columns + 1.0, 3.6 * -(-len(made) // columns)))
    figure.set_layout_engine("constrained")
    grid = figure.subplots(-(-len(made) // columns), columns, sharey=True, squeeze=False)
    for axes in grid.flat[len(made) :]:
        axes.set_axis_off()
    for axes, (title, traces) in zip(grid.flat, made, strict=False):
        for trace in traces:
            marker, colour = trace["marker"]["symbol"], trace["line"]["color"]
            axes.plot(
                trace["x"],
                [float("nan") if value is None else value for value in trace["y"]],
                color=colour,
                linestyle="-" if "lines" in trace["mode"] else "",
                marker=_OF_MATPLOTLIB[marker.removesuffix("-open")],
                markerfacecolor="none" if marker.endswith("-open") else colour,
                label=unescape(trace["name"]) or None,
            )
        axes.set(xlabel=x, ylabel=y, title=title, **{f"{axis}scale": "log" for axis in plot.log})
        if any(trace["name"] for trace in traces):
            axes.legend(fontsize=6.5)
    return figure


def save(figure: Figure, file: Path) -> bytes:
    """Write a figure atomically as PNG, and return its content."""
    stream = BytesIO()
    with rc_context(STYLE):
        figure.savefig(stream, dpi=_DPI, format="png")
    write_whole(stream.getvalue(), file)
    return stream.getvalue()


def drawn_by_page(plot: Plot, frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Name, title and plotly.js figure of each panel of a plot."""
    axes: dict[str, Any] = {
        f"{axis}axis": {
            "title": {"text": literal(column(name, frame, plot.own).axis)},
            "type": "log" if axis in plot.log else "-",
            "exponentformat": "power" if axis in plot.log else "B",
        }
        for axis, name in (("x", plot.x), ("y", plot.y))
    }
    kept = {"meta": "shown", "mode": "markers", "x": [], "y": [], "name": "mode shown",
            "marker": {"symbol": "circle-open", "size": 18, "color": BLACK}}  # fmt: skip
    made, every = [], panels(plot, frame)
    for i, (title, traces) in enumerate(every):
        if any("customdata" in trace for trace in traces):
            traces.append(kept)
        room = 12 * len(traces)
        shown = {"height": 400 + room, "showlegend": len(traces) > 1, "meta": {"narrow": room}}
        name = f"{plot.name}-{i}" if len(every) > 1 else plot.name
        made.append(
            {"name": name, "title": title, "figure": {"data": traces, "layout": axes | shown}}
        )
    return made
