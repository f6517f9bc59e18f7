"""Picture of the study of the crowned pad."""

from pathlib import Path
from typing import Any

import numpy as np

from comparisons.kit.numbers import number
from comparisons.kit.plots import AXIS
from comparisons.paper.common.figure import Data
from comparisons.paper.common.style import COLOURS, drawing
from comparisons.paper.crowned_pad.case import COLLOCATION, EXACT, FINER, QUADRATURE, WEIGHTED
from comparisons.paper.crowned_pad.measures import distance

_SHOWN = (EXACT, FINER, QUADRATURE, COLLOCATION, "grid", WEIGHTED, "mortar")
_STYLES = ("-", "--", "-", "-", "-", "-.", ":")
_COLOURS = (*COLOURS, AXIS)


def draw_study(data: Data, file: Path, title: str) -> Path:
    """Draw a row for each kind of mesh: distance, closed area and growth against load, pressure.

    Parameters
    ----------
    data
        Computed data.
    file
        PNG file.
    title
        Title of the picture.
    """
    families = data["families"]
    with drawing(file, (13.0, 3.2 * len(families) + 0.7)) as figure:
        figure.suptitle(title, fontsize=10)
        rows = figure.subplots(len(families), 4, squeeze=False)
        for axes, (family, cases) in zip(rows, families.items(), strict=True):
            _draw_family(axes, data, cases)
            axes[0].set_title(family)
        handles, labels = rows[0][1].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return file


def _draw_family(axes: Any, data: Data, cases: Data) -> None:
    loads = np.array(data["pressures"]) / 1e6
    middle, shown = len(data["radii"]) // 2, len(loads) // 2
    for label, style, colour in zip(_SHOWN, _STYLES, _COLOURS, strict=True):
        row = cases[label]
        look = {"linestyle": style, "color": colour, "linewidth": 1.1, "label": label}
        if label != EXACT:
            far = [100 * distance(*pair) for pair in zip(row, cases[EXACT], strict=True)]
            axes[0].loglog(loads, far, marker="o", markersize=3, **look)
        axes[1].semilogx(loads, [100 * case["closed"] for case in row], **look)
        line = np.array(row[shown]["pressure"]).reshape(len(data["radii"]), -1)[middle]
        axes[2].plot(data["angles"], line / 1e6, **look)
        axes[3].semilogx(loads, [case["growth"] for case in row], **look)
    load = "pressure on the back (MPa)"
    axes[0].set(xlabel=load, ylabel="pressure off segments (%)")
    axes[1].set(xlabel=load, ylabel="closed part of the pad (%)")
    axes[2].set(xlabel=f"angle (°) at {number(loads[shown])} MPa", ylabel="contact pressure (MPa)")
    axes[3].set(xlabel=load, ylabel="largest growth rate (1/s)")
    for each in axes:
        each.grid(visible=True)
