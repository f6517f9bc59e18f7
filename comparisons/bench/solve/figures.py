"""Error of the eigenvalues against run time."""

from statistics import median

from matplotlib.figure import Figure

from comparisons.bench.solve.tables import ran
from comparisons.kit.plots import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, styled
from comparisons.kit.tables import Data

_COLOURS = (VERMILION, BLUE, GREEN, ORANGE, PURPLE, SKY)
_ROUNDING = 1e-16
"""Where errors of nothing are drawn."""


@styled
def error_figure(data: Data) -> Figure:
    """Median and worst error of each method over its processor time."""
    figure = Figure(figsize=(6.6, 4.2), layout="constrained")
    axes = figure.subplots()
    for method, colour in zip(ran(data), _COLOURS, strict=False):
        time = median(method["processor"])
        middle, worst = (max(pick(method["errors"]), _ROUNDING) for pick in (median, max))
        axes.plot([time, time], [middle, worst], "-", color=colour, linewidth=1.2)
        axes.plot(time, middle, "o", color=colour, label=method["name"])
        axes.plot(time, worst, "v", color=colour)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("processor time, s")
    axes.set_ylabel("relative error of λ²: median (●), worst (▼)")
    axes.legend(loc="best")
    return figure


FIGURES = {"error_against_time": error_figure}
