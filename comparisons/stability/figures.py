"""Heat maps of digits by case and formulation."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from comparisons.kit.plots import BLACK, GREY, VERMILION, styled
from comparisons.kit.tables import Data
from comparisons.stability.parts.ways import ALONE, OPEN, WAYS
from comparisons.stability.tables import digits
from scenes.names import backend_name

_ROW, _COLUMN = 0.17, 0.27
"""Height of a row, width of a column (inches)."""
_LABELS = 4.2
"""Width of the labels of rows (inches)."""
_MOST = 14.0
"""Digits that have the last colour."""


def digits_map(subject: str, data: Data) -> Figure:
    """Correct digits of each run of a subject, a panel for each backend.

    Runs that were refused are grey, those that warn are marked by a circle, wrong ones by a cross.
    """
    return _drawn({"subject": subject, **data})


@styled
def _drawn(data: Data) -> Figure:
    runs = [r for r in data["runs"] if data["cases"][r["case"]]["subject"] == data["subject"]]
    rows = list(dict.fromkeys((run["case"], run["row"]) for run in runs))
    backends = list(dict.fromkeys(run["backend"] for run in runs))
    columns = {
        backend: sorted({r["formulation"] for r in runs if r["backend"] == backend}, key=_place)
        for backend in backends
    }
    widths = [len(columns[backend]) for backend in backends]
    size = (_LABELS + _COLUMN * (sum(widths) + 3), _ROW * len(rows) + 2.4)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(1, len(backends), squeeze=False, width_ratios=widths)[0]
    for axes, backend in zip(panels, backends, strict=True):
        own = [run for run in runs if run["backend"] == backend]
        image = _panel(axes, own, rows, columns[backend])
        axes.set_title(backend_name(backend))
    titles = [f"{data['cases'][case]['title'].split(',')[0]}: {row}" for case, row in rows]
    panels[0].set_yticks(range(len(rows)), titles, fontsize=6.5)
    for axes in panels[1:]:
        axes.set_yticks(range(len(rows)), [])
    bar = figure.colorbar(image, ax=panels, shrink=min(1.0, 3 / size[1]), pad=0.01)
    bar.set_label("correct digits of λ")
    return figure


def _place(formulation: str) -> int:
    """Place of a column."""
    return [way.name for way in (*WAYS, *OPEN, *ALONE)].index(formulation)


def _panel(axes: Axes, runs: list[Data], rows: list[tuple[str, str]], columns: list[str]) -> object:
    values = np.full((len(rows), len(columns)), np.nan)
    for run in runs:
        i, j = rows.index((run["case"], run["row"])), columns.index(run["formulation"])
        found = digits(run)
        if found is not None:
            values[i, j] = found
        if run["verdict"] == "refused":
            axes.plot(j, i, "s", color=GREY, markersize=7)
        elif run["verdict"] == "WRONG":
            axes.plot(j, i, "x", color=VERMILION, markersize=6, markeredgewidth=1.8)
        elif run["verdict"] == "warned":
            axes.plot(j, i, "o", color=BLACK, markersize=4, markerfacecolor="none")
    image = axes.imshow(values, cmap="viridis", vmin=0, vmax=_MOST, aspect="auto")
    axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=7)
    axes.grid(visible=False)
    return image
