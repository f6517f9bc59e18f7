"""Look of the plots of every application: colours, markers, style, and how a figure is written."""

from collections.abc import Callable
from functools import wraps
from io import BytesIO
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cea.files import write_whole

DPI = 200
"""Pixels per inch of the files: twice those a page shows."""

# Colours of Okabe and Ito, told apart with any colour vision.
ORANGE, SKY, GREEN, YELLOW = "#E69F00", "#56B4E9", "#009E73", "#F0E442"
BLUE, VERMILION, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#8A8A8A"
BLACK, AXIS, GRID = "#222222", "#555555", "#E4E4E4"

MARKERS = {"fe": "s", "iga": "o"}
"""Marker of each backend."""

_STYLE = {
    "font.family": "sans-serif",
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.edgecolor": AXIS,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": "#444444",
    "ytick.color": "#444444",
    "legend.frameon": False,
    "legend.fontsize": 8,
}


def styled(draw: Callable[[Any], Figure]) -> Callable[[Any], Figure]:
    """Give a figure the style of the report."""

    @wraps(draw)
    def styled(data: Any) -> Figure:
        with rc_context(_STYLE):
            figure = draw(data)
            FigureCanvasAgg(figure)
            return figure

    return styled


def save(figure: Figure, file: Path) -> None:
    """Write a figure as PNG at :data:`DPI`, whole or not at all."""
    with rc_context(_STYLE):
        write_whole(png(figure), file)


def png(figure: Figure, dpi: int = DPI) -> bytes:
    """A figure as the content of a PNG file."""
    stream = BytesIO()
    figure.savefig(stream, dpi=dpi, format="png")
    return stream.getvalue()
