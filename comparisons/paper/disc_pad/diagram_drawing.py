"""Stability diagrams as drawn: formulations by colour, kinds of meshes by marker."""

from collections.abc import Mapping, Sequence
from math import tau
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from comparisons.kit.plots import AXIS
from comparisons.paper.common.figure import Data
from comparisons.paper.common.style import COLOURS, drawing

_MARKERS = {"NURBS": "o", "hexahedra": "s", "tetrahedra": "^"}
_PANEL = (5.2, 4.0)
"""Width and height of a diagram (inches)."""
_SIZES = (7.5, 1.1)
"""Size of the first case's marker (points), and how much less the next is."""


def draw_diagrams(title: str, rows: Sequence[Mapping[str, list[Data]]], stem: Path) -> Path:
    """Draw diagrams.

    Parameters
    ----------
    title
        Above all.
    rows
        For each row of diagrams, panels by the kind of mesh; several kinds are overlaid.
    stem
        Path of the picture without its ending.
    """
    columns = max(len(panels) for row in rows for panels in row.values())
    file = stem.with_suffix(".png")
    width, height = _PANEL
    with drawing(file, (max(width * columns, 7.0), 0.5 + height * len(rows))) as figure:
        figure.suptitle(title, fontsize=10)
        grid = figure.subplots(len(rows), columns, sharex=True, squeeze=False)
        for line, row in zip(grid, rows, strict=True):
            for axes, panels in zip(line, zip(*row.values(), strict=True), strict=True):
                _draw_panel(axes, dict(zip(row, panels, strict=True)))
    return file


def _draw_panel(axes: Axes, panels: Mapping[str, Data]) -> None:
    """Growth of every mode over its frequency; decaying partners mirror the growing ones."""
    handles: list[Any] = []
    for family, panel in panels.items():
        names = _distinct(list(panel["cases"]))
        for i, (label, case) in enumerate(panel["cases"].items()):
            values = np.array([[v["im"] / tau, v["re"]] for v in case["eigenvalues"]])
            (line,) = axes.plot(
                values[:, 0] / 1e3,
                values[:, 1],
                _MARKERS[family],
                color=COLOURS[i % len(COLOURS)],
                markersize=_SIZES[0] - _SIZES[1] * i,
                markerfacecolor="none" if i % 2 == 0 else COLOURS[i % len(COLOURS)],
                markeredgewidth=1.1,
                linestyle="none",
                label=names[label] if len(panels) == 1 else f"{family}: {names[label]}",
            )
            handles.append(line)
    axes.axhline(0.0, color=AXIS, linewidth=0.6)
    axes.grid(visible=True)
    kinds = " and ".join(panels) if len(panels) < 3 else "all meshes"
    title = next(iter(panels.values()))["title"]
    axes.set_title(f"{title}, {kinds}")
    axes.set(xlabel="frequency (kHz)", ylabel="growth rate (1/s)")
    _, top = axes.get_ylim()
    axes.set_ylim(-0.15 * top, 1.08 * top)
    axes.legend(
        handles=[_legend(h) for h in handles],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.16),
        ncols=max(2, len(panels)),
        fontsize=6.5,
    )


def _distinct(labels: list[str]) -> dict[str, str]:
    """Labels without what all have in common."""
    parts = [label.split(", ") for label in labels]
    common = set.intersection(*map(set, parts)) if len(parts) > 1 else set()
    return {
        label: ", ".join(part for part in each if part not in common)
        for label, each in zip(labels, parts, strict=True)
    }


def _legend(line: Any) -> Line2D:
    return Line2D(
        [],
        [],
        marker=line.get_marker(),
        color=line.get_color(),
        markerfacecolor=line.get_markerfacecolor(),
        markersize=line.get_markersize(),
        linestyle="none",
        label=line.get_label(),
    )
