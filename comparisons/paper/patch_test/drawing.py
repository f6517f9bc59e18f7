"""Figures of the patch test in the paper's layout: normal stress along a line and as maps.

Lines are the normal stress less the exact one, maps the normal stress less its mean, each on its
own scale, since oscillations go from 1e-9 to 3000 N/m^2.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import SubFigure
from matplotlib.lines import Line2D

from cea.arrays import Floats
from comparisons.kit.numbers import number
from comparisons.kit.plots import GREY
from comparisons.paper.common.figure import Data
from comparisons.paper.common.style import SIDES, drawing
from comparisons.paper.patch_test.case import EXACT

_COLUMNS = 5
_COLUMN_SIZE = (2.9, 6.8)
"""Width and height (inches) of the three panels of a case."""


def draw_cases(data: Data, file: Path) -> Path:
    """Draw every case of computed data: lines of both sides above, maps of a and b below."""
    cases = list(data["cases"].values())
    rows = -(-len(cases) // _COLUMNS)
    columns = -(-len(cases) // rows)
    width, height = _COLUMN_SIZE
    with drawing(file, (max(width * columns, 6.0), 0.6 + height * rows)) as figure:
        figure.suptitle(data["title"], fontsize=10)
        places = figure.subfigures(rows, columns, squeeze=False).ravel()
        for place, case in zip(places, cases, strict=False):
            _draw_case(place, case)
        figure.legend(
            handles=[
                Line2D([], [], color=colour, linestyle=style, label=rf"$\sigma_n^{{({side})}}$")
                for side, colour, style in SIDES
            ]
            + [Line2D([], [], color=GREY, linestyle=":", label="$-p g$")],
            loc="outside lower center",
            ncols=3,
        )
    return file


def _draw_case(place: SubFigure, case: Data) -> None:
    line, *maps = place.subplots(3, 1, height_ratios=(1, 1.1, 1.1))
    for side, colour, style in SIDES:
        line.plot(
            case["line"]["arc"],
            _deviation(case["line"][side]),
            style,
            color=colour,
            linewidth=1.2,
        )
    low, high = line.get_ylim()
    pressure = -np.array(case["line"]["p_gap"], dtype=float) - EXACT
    # Where P is large p g is noise, far beyond the panel: all but vertical lines across it.
    pressure[(pressure < low) | (pressure > high)] = np.nan
    line.plot(case["line"]["arc"], pressure, ":", color=GREY, linewidth=0.9)
    contact = f"{case['rule']}, P = {number(case['P'], 1)} N/m"
    line.set_title(f"{case['mesh']}, {case['space']}\n{contact}")
    line.set_xlabel("along the diagonal (m)")
    line.set_ylabel(r"$\sigma_n + 1000$ (N/m²)")
    line.grid(visible=True)
    line.ticklabel_format(axis="y", scilimits=(-2, 3))
    x, y = case["map"]["x"], case["map"]["y"]
    for axes, side in zip(maps, "ab", strict=True):
        stress = _deviation(case["map"][side])
        stress -= np.nanmean(stress)
        extreme = float(np.nanmax(np.abs(stress))) or 1.0
        image = axes.imshow(
            stress,
            origin="lower",
            extent=(x[0], x[-1], y[0], y[-1]),
            cmap="RdBu_r",
            vmin=-extreme,
            vmax=extreme,
        )
        axes.set_title(f"side {side}: oscillation {number(case['oscillation'][side])} N/m²")
        bar = place.colorbar(image, ax=axes, shrink=0.85)
        bar.formatter.set_powerlimits((-2, 3))


def _deviation(sigma_n: list[Any]) -> Floats:
    """Normal stress less the exact one; None, beside a surface, becomes NaN."""
    return np.array(sigma_n, dtype=float) - EXACT
