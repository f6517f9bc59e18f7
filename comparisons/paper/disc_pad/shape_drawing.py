"""Mode shapes of Figures 4 and 5 as drawn: deformed bodies, and lines across the contact."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from comparisons.kit.plots import BLUE, GREY, VERMILION
from comparisons.paper.common.figure import Data
from comparisons.paper.common.style import drawing

_COLUMNS = {"lumped": "with lumping", "plain": "without lumping"}
_PICTURE = (5.0, 3.3)
"""Width and height of a mode (inches)."""
_LINES = (("disc", BLUE, "-"), ("pad", VERMILION, "--"))


def draw_shapes(title: str, families: Mapping[str, Data], stem: Path) -> Path:
    """Draw the deformed bodies of each kind of mesh, lumped on the left."""
    from scenes.pictures.drawing import Drawing

    file = stem.with_suffix(".png")
    width, height = _PICTURE
    with drawing(file, (2 * width, 0.5 + height * len(families))) as figure:
        figure.suptitle(title, fontsize=10)
        grid = figure.subplots(len(families), 2, squeeze=False)
        for row, (family, found) in zip(grid, families.items(), strict=True):
            for axes, (name, words) in zip(row, _COLUMNS.items(), strict=True):
                mode = found[name]
                bodies = {body: stored_outside(part) for body, part in mode["bodies"].items()}
                (image,) = Drawing.of(bodies, "").images([0.0])
                axes.imshow(np.asarray(image))
                axes.set_axis_off()
                axes.set_title(
                    f"{family}, {words}: {mode['frequency']:.1f} Hz, {mode['growth']:+.2f} 1/s"
                )
    return file


def stored_outside(body: Mapping[str, Any]) -> Any:
    """Outside of a body for pictures as it was stored, with its displacements."""
    from scenes.pictures.grids import straight_outside

    points, cells = np.array(body["points"]), np.array(body["cells"])
    return straight_outside(points, cells, np.array(body["displacement"], dtype=float))


def draw_lines(title: str, families: Mapping[str, Data], edge: float, stem: Path) -> Path:
    """Draw normal displacements along the line, which crosses the pad's boundary at -+ edge (m)."""
    file = stem.with_suffix(".png")
    width, height = _PICTURE
    with drawing(file, (2 * width, 0.8 + height * len(families))) as figure:
        figure.suptitle(title, fontsize=10)
        grid = figure.subplots(len(families), 2, squeeze=False, sharex=True, sharey=True)
        for row, (family, found) in zip(grid, families.items(), strict=True):
            for axes, (name, words) in zip(row, _COLUMNS.items(), strict=True):
                line = found[name]["line"]
                arc = 1e3 * np.array(line["arc"])
                for body, colour, style in _LINES:
                    # None, where the line leaves the pad, becomes NaN: a gap.
                    u = np.array(line[body], dtype=float)
                    axes.plot(arc, u, style, color=colour, linewidth=1.3)
                for side in (-1e3, 1e3):
                    axes.axvline(side * edge, color=GREY, linewidth=0.8, linestyle=":")
                axes.set_title(f"{family}, {words}")
                axes.grid(visible=True)
            row[0].set_ylabel(r"$u \cdot n$, largest of the disc 1")
        for axes in grid[-1]:
            axes.set_xlabel("along the line (mm); dotted: boundary of the pad")
        figure.legend(
            handles=[
                Line2D([], [], color=colour, linestyle=style, label=rf"$u^{{({body[0]})}} \cdot n$")
                for body, colour, style in _LINES
            ],
            loc="outside lower center",
            ncols=2,
        )
    return file
