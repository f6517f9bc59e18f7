"""Figures of a comparison, each a matplotlib figure made of its data and nothing else."""

from collections import Counter
from collections.abc import Callable
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from comparisons.agreement.tables import stage_times
from comparisons.kit.numbers import number
from comparisons.kit.plots import (
    AXIS,
    BLACK,
    BLUE,
    GREEN,
    GREY,
    MARKERS,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    YELLOW,
    styled,
)
from comparisons.kit.tables import Data, Table
from scenes.names import backend_name

COLOURS = {"node_to_surface": VERMILION, "greville": ORANGE, "grid": GREEN, "gpts": BLUE}
"""Colour of each formulation."""
_SIZES = {"fe": (11.0, 2.0), "iga": (5.5, 1.25)}
"""Size of the first formulation's marker (points), and how much less the next is."""


@styled
def patch_stresses(data: Data) -> Figure:
    """Normal stress of both sides along the diagonal, at the least P; a panel for each rule."""
    part = data["patch_test"]
    P = min(run["P"] for run in part["runs"])
    chosen = [run for run in part["runs"] if run["P"] == P]
    rows = [list(group) for _, group in groupby(chosen, key=lambda run: run["backend"])]
    columns = max(map(len, rows))
    figure = Figure(figsize=(10, 0.6 + 2.5 * len(rows)), layout="constrained")
    panels = figure.subplots(len(rows), columns, sharex=True, sharey=True, squeeze=False)
    for row, group in zip(panels, rows, strict=True):
        for axes in row[len(group) :]:
            axes.set_axis_off()
        for axes, run in zip(row, group, strict=False):
            _patch_panel(axes, run, part["exact_sigma_n"])
        row[0].set_ylabel("σₙ (N/m²)")
    for axes in panels[-1]:
        axes.set_xlabel("along the diagonal (m)")
    figure.legend(
        handles=[
            Line2D([], [], color=BLUE, label="side b"),
            Line2D([], [], color=VERMILION, linestyle="--", label="side a"),
            Line2D([], [], color=BLACK, linewidth=0.8, linestyle=":", label="exact"),
        ],
        loc="outside upper center",
        ncols=3,
        title=f"P = {number(P, 1)} N/m",
    )
    return figure


def _patch_panel(axes: Axes, run: Data, exact: float) -> None:
    sides = run["stresses"]["interface"]
    for side, colour, style in (("b", BLUE, "-"), ("a", VERMILION, "--")):
        # None, where the line leaves the surface, becomes NaN: a gap.
        sigma = np.array(sides[side]["sigma_n_along"], dtype=float)
        axes.plot(
            sides[side]["arc"], sigma, style, color=colour, linewidth=1.3, label=f"side {side}"
        )
    axes.axhline(exact, color=BLACK, linewidth=0.8, linestyle=":", label="exact", zorder=3)
    axes.set_title(f"{backend_name(run['backend'])}, {run['formulation']}")
    a, b = (number(sides[side]["oscillation"]) for side in "ab")
    axes.text(
        *(0.5, 0.03, f"oscillation a {a}, b {b}"),
        transform=axes.transAxes,
        ha="center",
        va="bottom",
        fontsize=7.5,
        color="#444444",
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5},
    )


@styled
def stability(data: Data) -> Figure:
    """Growth rate against frequency of every mode: backends by marker, formulations by colour."""
    runs = data["disc_pad"]["runs"]
    figure = Figure(figsize=(10, 4.6), layout="constrained")
    axes = figure.subplots()
    axes.axhline(0, color=AXIS, linewidth=0.8)
    drawn = Counter[str]()
    for run in runs:
        # Where modes agree their markers stand inside one another, and each is seen.
        largest, step = _SIZES[run["backend"]]
        size = largest - step * drawn[run["backend"]]
        drawn[run["backend"]] += 1
        axes.plot(
            [value["im"] / (2000 * np.pi) for value in run["eigenvalues"]],
            [value["re"] for value in run["eigenvalues"]],
            linestyle="none",
            marker=MARKERS[run["backend"]],
            markersize=max(size, 2.0),
            markerfacecolor="none",
            markeredgecolor=COLOURS[run["method"]],
            markeredgewidth=1.1,
            label=f"{backend_name(run['backend'])}, {run['formulation']}",
        )
    extent = max((abs(v["re"]) for run in runs for v in run["eigenvalues"]), default=0.0) or 1.0
    axes.set_ylim(-1.15 * extent, 1.15 * extent)
    axes.set_xlim(left=0)
    axes.set_xlabel("frequency (kHz)")
    axes.set_ylabel("growth rate (1/s)")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


@styled
def disc_errors(data: Data) -> Figure:
    """Errors of the disc's frequencies against run time, and against dofs."""
    figure = Figure(figsize=(10, 4.8), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    colours = (VERMILION, ORANGE, BLUE, GREEN, PURPLE, SKY)
    lines: dict[str, list[Any]] = {}
    for run in data["disc_alone"]["runs"]:
        lines.setdefault(run["line"], []).append(run)
    handles = []
    for i, (line, runs) in enumerate(lines.items()):
        colour, marker = colours[i % len(colours)], MARKERS[runs[0]["backend"]]
        abscissae = [r["seconds"] for r in runs], [r["dofs"]["free"] for r in runs]
        for axes, x in zip(panels, abscissae, strict=True):
            for key, style, size in (("worst_error", "-", 5), ("median_error", "--", 3)):
                axes.loglog(
                    x,
                    [run[key] for run in runs],
                    style,
                    color=colour,
                    marker=marker,
                    markersize=size,
                    linewidth=1.3 if style == "-" else 0.9,
                    label=f"{line}, {key.removesuffix('_error')}",
                )
        handles.append(Line2D([], [], color=colour, marker=marker, markersize=5, label=line))
    handles += [
        Line2D([], [], color=GREY, label="worst"),
        Line2D([], [], color=GREY, linestyle="--", linewidth=0.9, label="median"),
    ]
    for axes in panels:
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(lambda value, _: number(value, 1))
        axes.xaxis.set_minor_formatter(NullFormatter())
    panels[0].set_xlabel("run time (s)")
    panels[0].set_ylabel("relative error of frequency")
    panels[1].set_xlabel("dofs")
    figure.legend(handles=handles, loc="outside upper center", ncols=4)
    return figure


@styled
def stage_bars(data: Data) -> Figure:
    """Run time of every run by stage as stacked bars, a panel for each part."""
    table = stage_times(data)
    stages = [column.title for column in table.columns[2:-1]]
    parts = [(part, list(rows)) for part, rows in groupby(table.rows, key=lambda row: row[0])]
    counts = [len(rows) for _, rows in parts]
    figure = Figure(figsize=(10, 1.0 + 0.21 * sum(counts) + 0.55 * len(parts)))
    figure.set_layout_engine("constrained")
    panels = figure.subplots(
        len(parts), 1, squeeze=False, gridspec_kw={"height_ratios": [n + 1 for n in counts]}
    )[:, 0]
    for axes, (part, rows) in zip(panels, parts, strict=True):
        _bars(axes, rows, table, stages)
        axes.set_title(part, loc="left", fontweight="bold")
    panels[-1].set_xlabel("seconds")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(stages))
    return figure


def _bars(axes: Axes, rows: list[tuple[Any, ...]], table: Table, stages: list[str]) -> None:
    colours = (GREY, YELLOW, SKY, BLUE, VERMILION, GREEN, PURPLE, ORANGE)
    seconds = np.array([row[2:-1] for row in rows], dtype=float)
    left = np.cumsum(seconds, axis=1) - seconds
    place = np.arange(len(rows))
    for j, stage in enumerate(stages):
        colour = colours[j % len(colours)]
        axes.barh(place, seconds[:, j], 0.72, left[:, j], color=colour, label=stage)
    axes.set_yticks(place, [row[1] for row in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0, labelsize=8)
    axes.margins(x=0.08)
    total = table.columns[-1]
    for y, row in zip(place, rows, strict=True):
        axes.annotate(
            total.cell(row[-1]),
            (sum(row[2:-1]), y),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=7.5,
            color="#444444",
        )


FIGURES: dict[str, Callable[[Data], Figure]] = {
    "patch_stresses": patch_stresses,
    "stability": stability,
    "disc_errors": disc_errors,
    "stage_times": stage_bars,
}
"""Figures by the stem of their file."""
