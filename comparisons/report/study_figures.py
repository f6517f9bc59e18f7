"""Figures of the studies of contact formulations."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from comparisons.report.figures import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    save,
    styled,
)
from comparisons.report.numbers import backend_name, number
from comparisons.report.tables import Data

BLACK = "#222222"

_LINES = {
    "node-to-surface": (VERMILION, "s"),
    "Greville": (VERMILION, "s"),
    "Botella": (ORANGE, "D"),
    "grid": (GREEN, "v"),
    "segments": (PURPLE, "^"),
    "mortar": (BLUE, "*"),
}
"""Colour and marker of each formulation."""

_GPTS = ((SKY, "o"), (GREY, "h"), (BLACK, "8"))
"""The same of GPTS with rising numbers of points."""

_OPTIONS = {"": "-", "area": "--", "tributary": "--", "lumped": ":", "full pass": "-."}
"""Line of each option of a formulation."""

_BEYOND = 30.0
"""How far beyond the largest p infinity is drawn."""


def draw_locking(data: Data, file: Path) -> Path:
    """Draw the worst error of the lowest eigenvalues against p, a panel for each backend.

    Parameters
    ----------
    data
        What :func:`comparisons.studies.locking.run_locking` gave.
    file
        PNG to write.
    """
    save(_locking(data), file)
    return file


@styled
def _locking(data: Data) -> Figure:
    backends = list(dict.fromkeys(run["backend"] for run in data["runs"]))
    figure = Figure(figsize=(5.2 * len(backends), 5.6), layout="constrained")
    panels = figure.subplots(1, len(backends), sharey=True, squeeze=False)[0]
    a, b = (data["study"][f"elements_{side}"][0] for side in "ab")
    for axes, backend in zip(panels, backends, strict=True):
        for run in data["runs"]:
            if run["backend"] == backend:
                _line(axes, data, run)
        axes.set_title(f"{backend_name(backend)}, {a} against {b} elements")
        axes.set_xlabel("contact stiffness p")
        if data["study"]["tied"]:
            ticks = data["p"][::2]
            infinity = _BEYOND * max(data["p"])
            axes.set_xticks([*ticks, infinity], [*(number(p, 1) for p in ticks), "∞"])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.legend(
            loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, title="contact (points)"
        )
    top = number(data["study"]["max_frequency"], 2)
    panels[0].set_ylabel(f"worst relative error of λ up to Im λ = {top}")
    return figure


def _line(axes: Axes, data: Data, run: Data) -> None:
    word, _, option = run["formulation"].partition(", ")
    gauss = [f"GPTS {n}" for n in data["study"]["gauss"]]
    colour, marker = _GPTS[gauss.index(word) % len(_GPTS)] if word in gauss else _LINES[word]
    style = {
        "color": colour,
        "marker": marker,
        "markersize": 8 if option else 5,
        "markerfacecolor": "none",
        "linewidth": 1.2,
    }
    # None, where an eigenvalue was lost, becomes NaN: a gap.
    errors = np.array(run["errors"], dtype=float)
    label = f"{run['formulation']} ({run['points']})"
    axes.loglog(data["p"], errors, _OPTIONS[option], label=label, **style)
    if run["tied_error"] is not None:
        axes.loglog([_BEYOND * max(data["p"])], [run["tied_error"]], linestyle="none", **style)
