"""Time of an element against degree, and memory, of every program."""

from collections.abc import Callable

from matplotlib.figure import Figure

from comparisons.bench.assembly.tables import ran, seconds
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
from comparisons.kit.tables import Data

_COLOURS = (VERMILION, BLACK, GREY, BLUE, GREEN, ORANGE, PURPLE, SKY)
_FAMILIES = {"NURBS": "NURBS", "Q": "Lagrange hexahedra", "P": "Lagrange tetrahedra"}


@styled
def times_figure(data: Data) -> Figure:
    """Processor milliseconds of an element against degree, a plot for each family."""
    return _against_degree(
        data, lambda run: 1e3 * seconds(run) / run["elements"], "stiffness and mass, ms/element"
    )


@styled
def memory_figure(data: Data) -> Figure:
    """Largest memory while assembling over that of the finished matrices, against degree."""
    return _against_degree(
        data, lambda run: run["peak"] / run["finished"], "peak memory / finished matrices"
    )


def _against_degree(data: Data, value: Callable[[Data], float], title: str) -> Figure:
    """A number of every run against degree, on a logarithmic scale."""
    runs = ran(data)
    programs = list(dict.fromkeys(run["program"] for run in runs))
    families = [name for name in _FAMILIES if any(run["family"] == name for run in runs)]
    figure = Figure(figsize=(3.2 * max(len(families), 1) + 1.2, 3.6), layout="constrained")
    plots = figure.subplots(1, max(len(families), 1), sharey=True, squeeze=False)[0]
    for axes, family in zip(plots, families, strict=False):
        for program, colour in zip(programs, _COLOURS, strict=False):
            own = [r for r in runs if r["family"] == family and r["program"] == program]
            points = [(run["degree"], value(run)) for run in own if value(run) > 0]
            if points:
                line = zip(*points, strict=True)
                axes.semilogy(*line, "o-", color=colour, markersize=4, label=program)
        axes.set_title(_FAMILIES[family])
        axes.set_xlabel("degree")
        axes.set_xticks(sorted({run["degree"] for run in runs if run["family"] == family}))
    plots[0].set_ylabel(title)
    handles = {
        label: line
        for axes in plots
        for line, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(handles.values(), handles.keys(), loc="outside right center")
    return figure


FIGURES = {"times": times_figure, "memory": memory_figure}
