"""What moves growth rates: derivatives in the axes of a map, as a table and as a picture."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from comparisons.kit.numbers import shown
from comparisons.kit.plots import AXIS, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION, styled
from comparisons.kit.tables import Column, Data, Table
from comparisons.sweep.map_tables import places
from comparisons.sweep.rows import UNSTABLE, Row

_COLOURS = (VERMILION, BLUE, GREEN, ORANGE, PURPLE, SKY)


def sensitivities_table(data: Data, rows: Sequence[Row]) -> Table:
    """A row for the fastest growing mode of each value, where one grows."""
    names = [axis["name"] for axis in data["axes"]]
    made: list[tuple[Any, ...]] = []
    for at, row, i in places(data, rows):
        grows = np.where(row.verdict[i] == UNSTABLE, row.growth[i], -np.inf)
        if not np.isfinite(grows).any():
            continue
        top = int(np.argmax(grows))
        slopes = row.growth_slope[i, top].tolist()
        moved = [slope * value for slope, value in zip(slopes, at, strict=True)]
        of_frequency = row.frequency_slope[i, top].tolist()
        made.append(
            (*at, float(row.frequency[i, top]), float(grows[top]), *slopes, *moved, *of_frequency)
        )
    return Table(
        "sensitivities",
        "What moves the growth rate of the fastest mode: its derivatives; times the value of the "
        "field, what a change by its whole would make; derivatives of the frequency.",
        (
            *(Column(name, name, shown(6)) for name in names),
            Column("frequency", "frequency", shown(6), "Hz"),
            Column("growth", "growth", shown(5, sign=True), "1/s"),
            *(Column(f"slope {n}", f"d growth / d {n}", shown(4, sign=True)) for n in names),
            *(Column(f"whole {n}", f"times {n}", shown(4, sign=True), "1/s") for n in names),
            *(Column(f"shift {n}", f"d frequency / d {n}", shown(4, sign=True)) for n in names),
        ),
        made,
    )


@styled
def sensitivities_figure(drawn: Data) -> Figure:
    """Derivatives of growth rates along the first axis, a panel for each axis.

    Next to a coalescence they have no bound; scales are those of nine tenths of all values.

    Parameters
    ----------
    drawn
        ``data`` of the map, one ``row`` of it and the words ``at`` of that row.
    """
    data, row = drawn["data"], drawn["row"]
    first = data["axes"][0]
    values, count = np.array(first["values"]), len(data["axes"])
    figure = Figure(figsize=(9.4, 2.6 * count + 0.6), layout="constrained")
    spaces = figure.subplots(count, 1, sharex=True, squeeze=False).ravel()
    grows = np.unique(row.branch[(row.verdict == UNSTABLE) & (row.branch >= 0)]).tolist()
    for space, axis, own in zip(spaces, data["axes"], range(count), strict=True):
        slopes = []
        for i, number in enumerate(grows):
            at, mode = np.nonzero(row.branch == number)
            slope = row.growth_slope[at, mode, own]
            label = f"{row.frequency[at[0], mode[0]]:,.0f} Hz".replace(",", "\u202f")
            colour = _COLOURS[i % len(_COLOURS)]
            space.plot(values[at], slope, ".-", ms=3, linewidth=0.8, color=colour, label=label)
            slopes.append(slope)
        sizes = np.abs(np.concatenate(slopes)) if slopes else np.empty(0)
        sizes = sizes[np.isfinite(sizes)]
        if len(sizes) and (most := 1.2 * np.quantile(sizes, 0.9)) > 0:
            space.set_ylim(-most, most)
        space.axhline(0.0, color=AXIS, linewidth=0.8)
        for each in row.thresholds:
            space.axvline(each.value, color=GREY, linewidth=0.5, linestyle=":")
        space.set_ylabel(f"d growth / d {axis['name']}")
    spaces[-1].set_xlabel(first["name"])
    spaces[0].set_title(f"Sensitivities of growing branches{drawn['at']}")
    if grows:
        handles, labels = spaces[0].get_legend_handles_labels()
        figure.legend(handles[:18], labels[:18], loc="outside right upper")
    return figure
