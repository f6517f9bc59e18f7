"""Growth rates and frequencies along a sweep, unstable modes drawn out."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from comparisons.kit.plots import AXIS, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION, styled
from comparisons.kit.tables import Data
from comparisons.sweep.study import curves_of

_COLOURS = (VERMILION, BLUE, GREEN, ORANGE, PURPLE, SKY)
_STYLES = ("-", "--", ":")
_LOGARITHMIC = 100.0
"""Range of growth rates of unstable modes from which on their scale is logarithmic."""

_ROOM = 4.0
"""Room above the fastest on that scale, as a factor."""


@styled
def sweep_figure(data: Data) -> Figure:
    """Growth rate and frequency of every mode, those that are unstable somewhere in colour."""
    figure = Figure(figsize=(7.2, 6.4), layout="constrained")
    growth, frequency = figure.subplots(2, 1, sharex=True)
    curves = curves_of(data)
    unstable = [n for n, curve in curves.items() if curve["unstable"].any()]
    unstable.sort(key=lambda n: float(curves[n]["frequency"][0]))
    looks = [(style, colour) for style in _STYLES for colour in _COLOURS]
    for number, curve in curves.items():
        if number in unstable:
            style, colour = looks[unstable.index(number) % len(looks)]
            label = f"{curve['frequency'][0]:,.0f} Hz".replace(",", "\u202f")
            options = {"color": colour, "linestyle": style, "linewidth": 1.5, "zorder": 3}
            growth.plot(curve["value"], curve["growth"], label=label, **options)
            frequency.plot(curve["value"], curve["frequency"], **options)
            grows = curve["unstable"]
            for axes, name in ((growth, "growth"), (frequency, "frequency")):
                axes.plot(curve["value"][grows], curve[name][grows], "o", color=colour, ms=3)
        else:
            for axes, name in ((growth, "growth"), (frequency, "frequency")):
                axes.plot(curve["value"], curve[name], color=GREY, linewidth=0.6, marker=".", ms=2)
    _growth_axis(growth, [curves[n]["growth"] for n in unstable])
    failed = [point["value"] for point in data["points"] if point["failed"]]
    for value in failed:
        growth.axvline(value, color=GREY, linestyle=":", linewidth=0.8)
        frequency.axvline(value, color=GREY, linestyle=":", linewidth=0.8)
    frequency.set_ylabel("frequency (Hz)")
    frequency.set_xlabel(data["field"])
    if unstable:
        figure.legend(loc="outside right upper", title="unstable")
    note = f"; no answer at {len(failed)} values" if failed else ""
    growth.set_title(f"Modes along {data['field']}, unstable ones in colour{note}")
    return figure


def _growth_axis(axes: Axes, growths: list[np.ndarray]) -> None:
    """Zero marked; a scale on which slow growth is seen beside fast, where both occur."""
    axes.axhline(0.0, color=AXIS, linewidth=0.8)
    axes.set_ylabel("growth rate (1/s)")
    positive = np.concatenate([g[g > 0] for g in growths]) if growths else np.empty(0)
    if len(positive) and positive.max() > _LOGARITHMIC * positive.min():
        axes.set_yscale("symlog", linthresh=10.0 ** np.floor(np.log10(positive.min())))
        axes.set_ylim(top=_ROOM * positive.max())
