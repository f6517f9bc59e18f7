"""Figures of the studies of contact formulations."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from cea.contact.formulations import (
    Botella,
    GaussPointToSurface,
    Greville,
    Grid,
    Mortar,
    NodeToSurface,
    Segments,
)
from comparisons.formulations.pairing_tables import pairing_name
from comparisons.kit.numbers import number
from comparisons.kit.plots import (
    BLACK,
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
from comparisons.kit.tables import Data
from scenes.names import backend_name

_LINES = {
    NodeToSurface.name: (VERMILION, "s"),
    Greville.name: (VERMILION, "s"),
    Botella.name: (ORANGE, "D"),
    Grid.name: (GREEN, "v"),
    Segments.name: (PURPLE, "^"),
    Mortar.name: (BLUE, "*"),
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
        What :func:`comparisons.formulations.locking.run_locking` gave.
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


def line_style(formulation: str, gauss: list[int]) -> dict[str, Any]:
    """Colour, marker and line of a formulation by its label.

    Parameters
    ----------
    formulation
        Label (:mod:`comparisons.formulations.variants`).
    gauss
        Numbers of Gauss points of the study, in the order of their colours.
    """
    word, _, option = formulation.partition(", ")
    names = [f"{GaussPointToSurface.name} {n}" for n in gauss]
    colour, marker = _GPTS[names.index(word) % len(_GPTS)] if word in names else _LINES[word]
    return {
        "color": colour,
        "marker": marker,
        "markersize": 8 if option else 5,
        "markerfacecolor": "none",
        "linestyle": _OPTIONS[option],
        "linewidth": 1.2,
    }


def _line(axes: Axes, data: Data, run: Data) -> None:
    style = line_style(run["formulation"], data["study"]["gauss"])
    # None, where an eigenvalue was lost, becomes NaN: a gap.
    errors = np.array(run["errors"], dtype=float)
    axes.loglog(data["p"], errors, label=f"{run['formulation']} ({run['points']})", **style)
    if run["tied_error"] is not None:
        infinity = _BEYOND * max(data["p"])
        axes.loglog([infinity], [run["tied_error"]], **style | {"linestyle": "none"})


def draw_patch_test_errors(data: Data, file: Path) -> Path:
    """Draw the errors of the patch tests against P: interfaces in rows, meshes in columns.

    Parameters
    ----------
    data
        What :func:`comparisons.formulations.patch_tests.run_patch_tests` gave.
    file
        PNG to write.
    """
    save(_patch_test_errors(data), file)
    return file


@styled
def _patch_test_errors(data: Data) -> Figure:
    rows: dict[str, dict[str, list[Data]]] = {}
    for run in data["runs"]:
        row = rows.setdefault(run["interface"], {})
        row.setdefault(" on ".join(run["meshes"]), []).append(run)
    columns = max(map(len, rows.values()))
    figure = Figure(figsize=(2.9 * columns, 0.9 + 2.6 * len(rows)), layout="constrained")
    panels = figure.subplots(len(rows), columns, sharex=True, sharey=True, squeeze=False)
    lines: dict[str, Line2D] = {}
    for line, (interface, row) in zip(panels, rows.items(), strict=True):
        for axes in line[len(row) :]:
            axes.set_axis_off()
        for axes, (meshes, runs) in zip(line, row.items(), strict=False):
            for run in runs:
                style = line_style(run["formulation"], data["study"]["gauss"])
                # None, where the system was singular, becomes NaN; zero cannot be drawn.
                errors = np.array(run["errors"], dtype=float)
                errors[errors == 0] = np.nan
                (drawn,) = axes.loglog(data["P"], errors, **style)
                lines.setdefault(run["formulation"], drawn)
            axes.axhline(data["passed"], color=BLACK, linewidth=0.8, linestyle=":")
            axes.set_title(f"{interface}, {meshes}")
            axes.xaxis.set_minor_locator(NullLocator())
        line[0].set_ylabel("largest relative error of σₙ")
    for axes in panels[-1]:
        axes.set_xlabel("P (N/m)")
    figure.legend(list(lines.values()), list(lines), loc="outside upper center", ncols=6)
    return figure


def draw_pairings(data: Data, file: Path) -> Path:
    """Draw the growth of unstable modes against frequency, a marker for each pairing.

    Parameters
    ----------
    data
        What :func:`comparisons.formulations.pairings.run_pairings` gave.
    file
        PNG to write.
    """
    save(_pairings(data), file)
    return file


@styled
def _pairings(data: Data) -> Figure:
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    axes = figure.subplots()
    degree = data["study"]["refined_degree"]
    shown = [(run, pairing_name(run)) for run in data["runs"]]
    refined = data["refined"]
    shown.append((refined, f"{pairing_name(refined)}, degree {degree}"))
    marks = zip((VERMILION, ORANGE, GREEN, BLUE, BLACK), ("s", "D", "v", "o", "+"), strict=True)
    for (run, label), (colour, marker) in zip(shown, marks, strict=False):
        axes.plot(
            [mode["frequency"] / 1000 for mode in run["unstable"]],
            [mode["growth"] for mode in run["unstable"]],
            linestyle="none",
            marker=marker,
            markersize=8,
            markerfacecolor="none",
            markeredgecolor=colour,
            label=label,
        )
    axes.set_xlim(0, 1.02 * data["max_frequency"] / 1000)  # no marker is cut
    axes.set_ylim(bottom=0)
    axes.set_xlabel("frequency (kHz)")
    axes.set_ylabel("growth rate (1/s)")
    figure.legend(loc="outside upper center", ncols=3, title="pad on disc")
    return figure
