"""Pictures of samples: how probable growth is of each mode, how fast it is, and where."""

import numpy as np
from matplotlib.figure import Figure

from comparisons.kit.plots import AXIS, BLUE, GREY, VERMILION, styled
from comparisons.kit.tables import Data

_MOST = 25
"""Modes whose probability is drawn: the most probable ones."""


@styled
def probability_figure(drawn: Data) -> Figure:
    """Probabilities with their intervals, and the distribution of the largest growth.

    Parameters
    ----------
    drawn
        ``data`` of the samples and ``found``, their modes.
    """
    data, found = drawn["data"], drawn["found"]
    figure = Figure(figsize=(9.4, 4.8), layout="constrained")
    bars, growth = figure.subplots(1, 2)
    modes = sorted(data["modes"], key=lambda each: -each["probability"])[:_MOST]
    modes.sort(key=lambda each: each["frequency"])
    shown = [*modes, data["any"]]
    share = np.array([each["probability"] for each in shown])
    ends = np.array([[each["low"], each["high"]] for each in shown]).T
    # An interval may leave its share out where samples are undecided.
    errors = np.maximum([share - ends[0], ends[1] - share], 0.0)
    colours = [BLUE] * len(modes) + [VERMILION]
    bars.barh(np.arange(len(shown)), share, color=colours, xerr=errors, ecolor=AXIS)
    names = [f"{each['frequency']:,.0f} Hz".replace(",", "\u202f") for each in modes]
    bars.set_yticks(np.arange(len(shown)), [*names, "any"])
    bars.set_xlim(0, 1)
    bars.set_xlabel("probability of growth")
    bars.set_title("Modes that grow, intervals of 95 %")
    largest = np.where(found.grows, found.growth, -np.inf).max(axis=1, initial=-np.inf)
    rates = largest[np.isfinite(largest)]
    growth.hist(rates, bins=40, color=VERMILION)
    growth.set_xlabel("largest growth rate (1/s)")
    growth.set_ylabel("samples")
    growth.set_title(f"{len(rates)} of {len(largest)} samples grow")
    return figure


@styled
def scatter_figure(drawn: Data) -> Figure:
    """Where samples grow, over each field that is spread.

    Parameters
    ----------
    drawn
        ``fields``, what was drawn of each, and ``found``, the modes.
    """
    fields, found = drawn["fields"], drawn["found"]
    largest = np.where(found.grows, found.growth, -np.inf).max(axis=1, initial=-np.inf)
    grows = np.isfinite(largest)
    figure = Figure(figsize=(9.4, 3.2 * ((len(fields) + 1) // 2)), layout="constrained")
    spaces = figure.subplots((len(fields) + 1) // 2, min(len(fields), 2), squeeze=False).ravel()
    for space, field in zip(spaces, fields, strict=False):
        values = np.array(field.values)
        space.plot(values[~grows], np.zeros((~grows).sum()), ".", color=GREY, ms=2)
        space.plot(values[grows], largest[grows], ".", color=VERMILION, ms=2)
        if values.min() > 0 and values.max() > 20 * values.min():
            space.set_xscale("log")
        space.set_xlabel(field.name)
        space.set_ylabel("largest growth rate (1/s)")
    for space in spaces[len(fields) :]:
        space.remove()
    return figure
