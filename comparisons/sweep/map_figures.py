"""Pictures of maps: branches along the first axis, root locus, growth over two axes."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from comparisons.kit.plots import AXIS, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION, styled
from comparisons.kit.tables import Data
from comparisons.sweep.rows import UNSTABLE, Row

_COLOURS = (VERMILION, BLUE, GREEN, ORANGE, PURPLE, SKY)
_STYLES = ("-", "--", ":")


@styled
def branches_figure(drawn: Data) -> Figure:
    """Growth and frequency along the first axis, and the root locus beside them.

    Parameters
    ----------
    drawn
        ``data`` of the map, one ``row`` of it and the words ``at`` of that row.
    """
    data, row = drawn["data"], drawn["row"]
    figure = Figure(figsize=(9.4, 6.0), layout="constrained")
    spaces = figure.subplot_mosaic([["growth", "roots"], ["frequency", "roots"]])
    axis = data["axes"][0]
    values = np.array(axis["values"])
    looks = [(style, colour) for style in _STYLES for colour in _COLOURS]
    unstable = 0
    for number in np.unique(row.branch[row.branch >= 0]).tolist():
        there = (row.branch == number) & np.isfinite(row.growth)
        at, mode = np.nonzero(there)
        growth, frequency = row.growth[at, mode], row.frequency[at, mode]
        options: dict[str, Any] = {"color": GREY, "linewidth": 0.6, "zorder": 1}
        if (row.verdict[at, mode] == UNSTABLE).any():
            style, colour = looks[unstable % len(looks)]
            options = {"color": colour, "linestyle": style, "linewidth": 1.5, "zorder": 3}
            options["label"] = f"{frequency[0]:,.0f} Hz".replace(",", "\u202f")
            unstable += 1
        spaces["growth"].plot(values[at], growth, **options)
        options.pop("label", None)
        spaces["frequency"].plot(values[at], frequency, **options)
        spaces["roots"].plot(growth, frequency, **options)
        spaces["roots"].plot(growth[:1], frequency[:1], ".", color=options["color"], ms=3)
    for name in ("growth", "frequency"):
        spaces[name].set_xlabel(axis["name"])
        if _logarithmic(values):
            spaces[name].set_xscale("log")
        for each in row.thresholds:
            spaces[name].axvline(each.value, color=AXIS, linewidth=0.5, linestyle=":")
    spaces["growth"].axhline(0.0, color=AXIS, linewidth=0.8)
    spaces["growth"].set_ylabel("growth rate (1/s)")
    spaces["frequency"].set_ylabel("frequency (Hz)")
    spaces["roots"].axvline(0.0, color=AXIS, linewidth=0.8)
    spaces["roots"].set_xlabel("growth rate (1/s)")
    spaces["roots"].set_ylabel("frequency (Hz)")
    spaces["roots"].set_title("root locus, dots at the first value")
    if unstable:
        figure.legend(loc="outside right upper", title="unstable")
    spaces["growth"].set_title(f"Branches along {axis['name']}{drawn['at']}")
    return figure


@styled
def growth_figure(drawn: Data) -> Figure:
    """Largest growth over the first two axes, thresholds as dots.

    Parameters
    ----------
    drawn
        ``data`` of the map and its ``rows``, those of the first values of further axes.
    """
    data, rows = drawn["data"], drawn["rows"]
    x, y = (np.array(axis["values"]) for axis in data["axes"][:2])
    growth = np.array([_growth(row) for row in rows])
    figure = Figure(figsize=(7.2, 4.8), layout="constrained")
    space = figure.subplots()
    shown = np.ma.masked_invalid(growth)
    mesh = space.pcolormesh(x, y, shown, cmap="viridis", shading="nearest", rasterized=True)
    figure.colorbar(mesh, label="largest growth rate of an unstable mode (1/s)")
    for value, row in zip(y, rows, strict=True):
        for begins, look in ((True, "o"), (False, "x")):
            at = [each.value for each in row.thresholds if each.begins == begins]
            space.plot(at, np.full(len(at), value), look, color=VERMILION, ms=2.5)
    for values, name, scale in (
        (x, data["axes"][0]["name"], space.set_xscale),
        (y, data["axes"][1]["name"], space.set_yscale),
    ):
        if _logarithmic(values):
            scale("log")
        (space.set_xlabel if scale == space.set_xscale else space.set_ylabel)(name)
    _mark_uncertified(space, data, rows, x, y)
    above = np.isfinite(np.array([row.above_growth for row in rows]))
    if above.any():
        hatched = np.ma.masked_where(~above, np.ones(above.shape))
        space.pcolor(x, y, hatched, shading="nearest", hatch="///", alpha=0.0)
    told = ". Hatched: a mode grows just above the window" if above.any() else ""
    space.set_title(
        f"White: no growth above the threshold. Dots: growth begins; crosses: it ends{told}"
    )
    return figure


def _growth(row: Row) -> Any:
    """Largest growth rate of unstable modes at each value, NaN where none is."""
    growing = np.where(row.verdict == UNSTABLE, row.growth, -np.inf).max(axis=1, initial=-np.inf)
    return np.where(np.isfinite(growing), growing, np.nan)


def _mark_uncertified(
    space: Axes, data: Mapping[str, Any], rows: Sequence[Row], x: Any, y: Any
) -> None:
    """Grey crosses where no bound was reached."""
    tolerance = data["inputs"]["tolerance"]
    for value, row in zip(y, rows, strict=True):
        left = x[row.bound > tolerance]
        space.plot(left, np.full(len(left), value), "+", color=GREY, ms=4)


def _logarithmic(values: Any) -> bool:
    """Whether values are evenly spaced in their logarithm rather than by themselves."""
    if len(values) < 3 or not (values > 0).all():
        return False
    steps = np.diff(np.log(values))
    return bool(np.ptp(steps) < 1e-6 * np.abs(steps).max())
