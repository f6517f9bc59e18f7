"""Plots of data frames: matplotlib draws the PNG files, plotly the pages, both from same lines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from comparisons.kit.interactive import VERDICT_MARKS, literal
from comparisons.kit.plots import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    styled,
)
from comparisons.study.columns import column
from comparisons.study.sections import Plot

COLOURS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, BLACK, GREY)
"""Colours of the values of a series, in their order."""
_SHAPES = (
    *(("o", "circle"), ("s", "square"), ("^", "triangle-up"), ("D", "diamond")),
    *(("v", "triangle-down"), ("P", "cross"), ("*", "star")),
)
"""Markers of matplotlib and of plotly."""
_OF_MATPLOTLIB = {page: drawn for drawn, page in _SHAPES}
_BACKENDS = {"iga": _SHAPES[0], "fe": _SHAPES[1]}
_PANEL = (4.4, 3.6)
"""Width and height of a panel (inches)."""


@dataclass(frozen=True)
class Line:
    """A line of a plot, its marker and colour."""

    label: str
    x: list[Any]
    y: list[Any]
    colour: str
    marker: tuple[str, str] | None
    joined: bool
    shapes: list[str]


@dataclass(frozen=True)
class Panel:
    """A panel with its lines."""

    title: str
    lines: list[Line]


def panels(plot: Plot, result: Any) -> list[Panel]:
    """Lines of a plot by panel; none where there are no points."""
    frame = plot.frame(result)
    if frame.empty:
        return []
    exact = plot.lines(result) if plot.lines is not None else None
    looks = {name: _looks(frame, name, plot.series) for name in plot.series}
    values = list(frame[plot.panel].unique()) if plot.panel else [None]
    made = []
    for value in values:
        lines = []
        if exact is not None:
            own = _of_panel(exact, plot.panel, value)
            lines += _lines(plot, own, looks, marked=False, joined=True)
        own = _of_panel(frame, plot.panel, value)
        joined = exact is None and plot.style == "lines"
        lines += _lines(plot, own, looks, marked=True, joined=joined)
        title = column(plot.panel, frame, plot.own).cell(value) if plot.panel else ""
        made.append(Panel(title, lines))
    return made


def _of_panel(frame: pd.DataFrame, panel: str, value: Any) -> pd.DataFrame:
    return frame[frame[panel] == value] if panel and panel in frame else frame


def _looks(frame: pd.DataFrame, name: str, series: Sequence[str]) -> dict[Any, dict[str, Any]]:
    """Markers of backends, colours of anything else; marker and colour of a single series."""
    if name == "backend":
        alone = len(series) == 1
        colours = {"fe": BLUE, "iga": VERMILION}
        return {
            b: {"marker": m} | ({"colour": colours[b]} if alone else {})
            for b, m in _BACKENDS.items()
        }
    looks: dict[Any, dict[str, Any]] = {}
    for i, value in enumerate(frame[name].unique()):
        looks[value] = {"colour": COLOURS[i % len(COLOURS)]}
        if "backend" not in series:
            looks[value]["marker"] = _SHAPES[i // len(COLOURS) % len(_SHAPES)]
    if name == "verdict":
        for verdict, (symbol, colour, _) in VERDICT_MARKS.items():
            marker = (_OF_MATPLOTLIB[symbol.removesuffix("-open")], symbol)
            looks[verdict] = {"colour": colour, "marker": marker}
    return looks


def _lines(
    plot: Plot,
    frame: pd.DataFrame,
    looks: Mapping[str, Mapping[Any, dict[str, Any]]],
    *,
    marked: bool,
    joined: bool,
) -> list[Line]:
    keys = [name for name in plot.series if name in frame]
    groups = frame.groupby(keys, sort=False, dropna=False) if keys else [((), frame)]
    lines = []
    for values, own in groups:
        look: dict[str, Any] = {"colour": BLUE, "marker": _SHAPES[0]}
        for name, value in zip(keys, values, strict=True):
            look |= looks[name].get(value, {})
        text = [column(n, frame, plot.own) for n in keys]
        label = ", ".join(c.cell(v) for c, v in zip(text, values, strict=True))
        places = own[[plot.x, plot.y]].replace([float("inf"), float("-inf")], float("nan"))
        places = places.astype(object).where(places.notna(), None)
        shapes = list(own["shape"]) if "shape" in own else []
        marker = look["marker"] if marked else None
        x, y = places[plot.x].tolist(), places[plot.y].tolist()
        lines.append(Line(label, x, y, look["colour"], marker, joined, shapes))
    return lines


def _titles(plot: Plot, result: Any) -> tuple[str, str]:
    frame = plot.frame(result)
    x, y = (column(name, frame, plot.own).axis for name in (plot.x, plot.y))
    return x, y


def draw(plot: Plot, result: Any) -> Figure:
    """A figure of a plot, panels side by side."""
    return styled(lambda _: _draw(plot, result))(result)


def _draw(plot: Plot, result: Any) -> Figure:
    made, titles = panels(plot, result), _titles(plot, result)
    columns = min(3, len(made))
    rows = -(-len(made) // columns)
    figure = Figure(figsize=(_PANEL[0] * columns + 1.0, _PANEL[1] * rows), layout="constrained")
    grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for axes in grid.flat[len(made) :]:
        axes.set_axis_off()
    for axes, panel in zip(grid.flat, made, strict=False):
        for line in panel.lines:
            if plot.style == "bars":
                axes.bar([str(x) for x in line.x], line.y, color=line.colour, label=line.label)
                continue
            axes.plot(
                line.x,
                [float("nan") if y is None else y for y in line.y],
                color=line.colour,
                linestyle="-" if line.joined else "",
                marker=line.marker[0] if line.marker else "",
                markerfacecolor="none" if line.marker == _BACKENDS["fe"] else line.colour,
                markersize=5,
                linewidth=1.2,
                label=line.label or None,
            )
        for axis in plot.log:
            axes.set(**{f"{axis}scale": "log"})
        axes.set(xlabel=titles[0], ylabel=titles[1], title=panel.title)
        if any(line.label for line in panel.lines):
            axes.legend(fontsize=6.5)
    return figure


def drawn_by_page(plot: Plot, result: Any) -> list[dict[str, Any]]:
    """Figures of plotly.js with their names and titles, one for each panel."""
    axes = {
        f"{axis}axis": {
            "title": {"text": literal(title)},
            "type": "log" if axis in plot.log else "-",
            "exponentformat": "power" if axis in plot.log else "B",
        }
        for axis, title in zip("xy", _titles(plot, result), strict=True)
    }
    kept = {"meta": "shown", "mode": "markers", "x": [], "y": [], "name": "mode shown",
            "marker": {"symbol": "circle-open", "size": 18, "color": BLACK}}  # fmt: skip
    made, every = [], panels(plot, result)
    for i, panel in enumerate(every):
        traces = [_trace(line, plot.style) for line in panel.lines]
        if any(line.shapes for line in panel.lines):
            traces.append(kept)
        room = 12 * len(traces)
        layout = axes | {
            "height": 400 + room,
            "showlegend": len(traces) > 1,
            "meta": {"narrow": room},
        }
        name = f"{plot.name}-{i}" if len(every) > 1 else plot.name
        figure = {"data": traces, "layout": layout}
        made.append({"name": name, "title": panel.title, "figure": figure})
    return made


def _trace(line: Line, style: str) -> dict[str, Any]:
    trace: dict[str, Any] = {"x": line.x, "y": line.y, "name": literal(line.label)}
    if style == "bars":
        return trace | {"type": "bar", "marker": {"color": line.colour}}
    modes = [*(["lines"] if line.joined else []), *(["markers"] if line.marker else [])]
    trace |= {"type": "scatter", "mode": "+".join(modes), "line": {"color": line.colour}}
    if line.marker:
        symbol = line.marker[1] + ("-open" if line.marker == _BACKENDS["fe"] else "")
        trace["marker"] = {"color": line.colour, "symbol": symbol, "size": 8}
    return trace | ({"customdata": line.shapes} if line.shapes else {})
