"""Look of the figures: one style and the way a figure is written."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from cea.files import write_whole
from comparisons.kit.plots import AXIS, BLUE, GREEN, GRID, ORANGE, PURPLE, SKY, VERMILION, png

SIDES = (("b", BLUE, "-"), ("a", VERMILION, "--"))
"""Sides of a contact with colour and line: solid for b, dashed for a, as in the paper."""

COLOURS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY)
"""Colours of curves."""

_STYLE = {
    "font.family": "sans-serif",
    "font.size": 9,
    "axes.titlesize": 8.5,
    "axes.edgecolor": AXIS,
    "axes.linewidth": 0.7,
    "axes.formatter.useoffset": False,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
}


@contextmanager
def drawing(file: Path, size: tuple[float, float]) -> Iterator[Figure]:
    """Figure of a size (inches), written to a PNG file when the block ends."""
    with rc_context(_STYLE):
        figure = Figure(figsize=size, layout="constrained")
        yield figure
        write_whole(png(figure), file)
