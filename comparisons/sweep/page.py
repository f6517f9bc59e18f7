"""Presentation of a sweep: sweep.nc, the record, first lines, tables, pictures and the page."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from cea.eigen.classify import GROWING, WORDS, counted_words
from cea.petsc import MPI
from comparisons.study.closing import warned
from comparisons.study.columns import Column
from comparisons.study.numbers import counted, shown
from comparisons.study.page import REPORT, write
from comparisons.study.plots import AXIS, BLUE, GREY, VERMILION
from comparisons.study.result import RESULT, Data, read_result
from comparisons.study.run_warnings import kinds_at, named
from comparisons.study.sections import Section, Table
from comparisons.sweep.spectra import HINT, UNSTABLE, read_netcdf, write_netcdf
from comparisons.sweep.study import COMMAND, Swept
from scenes.results.record import write_record

FILE = "sweep.nc"
_ON_PAGE = 500
"""Largest number of rows of a table that the page shows; its file holds all."""
_WHAT = {
    "flutter": ("flutter begins", "flutter ends"),
    "divergence": ("divergence begins", "divergence ends"),
    "window": ("growing mode enters the window from above", "growing mode leaves the window"),
    "count": ("more modes grow", "fewer modes grow"),
}
"""Text for a threshold where the number of growing modes increases, and where it decreases."""


def write_sweep(made: Swept, out: Path) -> Path:
    """Write a sweep to a folder, on rank 0; return the path of the page."""
    if MPI.COMM_WORLD.rank:
        return out / REPORT
    out.mkdir(parents=True, exist_ok=True)
    write_netcdf(made.spectra, made.points, out / FILE)
    write_record(made.record, out / RESULT)
    title = f"Sweep of {made.record['inputs']['scene']}"
    return write(title, sections_of(made), made, out)


def read_sweep(out: Path) -> Swept:
    """Read a sweep from a folder; InputError when it holds none."""
    data = read_result(out, COMMAND)
    return Swept(data, *read_netcdf(out / FILE), None)


def headline(data: Data) -> str:
    """Return the main result of a sweep in one or two sentences."""
    if "fields" in data:
        told = f"{data['any']['grows']} of {data['values']} samples grow"
        undecided = data["any"]["undecided"]
        return told + (f", {undecided} are undecided." if undecided else ".")
    first, *others = data["axes"]
    along = f"{first['name']} = {first['ends'][0]:g} to {first['ends'][1]:g}"
    begun = [each for each in data["thresholds"] if each["change"] > 0]
    level = f"growth_threshold {data['growth_threshold'] or 0:g} 1/s"
    count, unresolved = len(data["thresholds"]), len(data["unresolved"])
    if others:
        told = f"{counted(count, 'threshold')} along {first['name']} ({level})."
    elif begun:
        one = min(begun, key=lambda each: each["value"])
        told = (
            f"Growth from {first['name']} = {one['value']:.4g} at {one['im'] / (2 * np.pi):.6g} Hz "
            f"(first of {count} thresholds for {along}; {level})."
        )
    else:
        grows = "Nothing begins to grow" if data["growing_at_first"] else "No flutter"
        sure = "" if unresolved or "why" in data else ", every interval resolved"
        told = f"{grows} for {along}{sure} ({level})."
    return told + (f" {unresolved} intervals unresolved." if unresolved else "")


def first_lines(made: Swept) -> list[str]:
    """Return the main result, the modes where growth is fastest, and how certain all this is."""
    data = made.record
    return [headline(data), *_factors(data), _fastest(made), _quality(data)]


def _factors(data: Data) -> list[str]:
    """Return a sentence for each field that is a factor on expressions of the scene."""
    fields = data["axes"] if "axes" in data else data["fields"]
    factors = {each["name"]: each.get("factor_on", ()) for each in fields}
    return [
        f"{name} is a factor on the scene's expression {' and '.join(paths)}, not its value."
        for name, paths in factors.items()
        if paths
    ]


def _fastest(made: Swept) -> str:
    """Return the number of modes of each class at the point of the largest growth rate."""
    data, points, spectra = made.record, made.points, made.spectra
    if not spectra.there.any():
        return f"No modes below {data['max_frequency']:g} Hz at any value."
    point = int(np.unravel_index(np.nanargmax(spectra.growth), spectra.growth.shape)[0])
    there = spectra.there[point]
    growth, verdicts = spectra.growth[point][there], spectra.verdict[point][there]
    at = named(dict(zip(points.names, points.values[point], strict=True)))
    counts = counted_words([WORDS[i] for i in verdicts], growth.tolist(), data["growth_threshold"])
    return f"Largest growth rate at {at}: {counted(len(growth), 'mode')}: {counts}."


def _quality(data: Data) -> str:
    """Return how many values are certified, and the size of the reduced model, in a sentence."""
    told = f"{data['certified']} of {data['values']} values "
    if "why" in data:
        told += f"have an answer. Solved in full at each value: {data['why']}"
    else:
        told += (
            f"certified, the worst relative bound is {data['worst']:.2g}; {max(data['vectors'])} "
            f"vectors of {len(data['snapshots'])} full solves with {data['unknowns']} unknowns"
        )
    if data["complete_to"] is not None:
        told += f"; complete up to a growth of {data['complete_to']:g} 1/s"
    return told + "."


def sections_of(made: Swept) -> list[Section]:
    """Return the sections of the page of a sweep."""
    own, few = _columns(made), len(made.points.values) <= _ON_PAGE
    drawing = map_figure if len(made.points.axes) > 1 else line_figure
    every = "All values: number of modes, growth rate and frequency of the fastest."
    basis = "Full solves of the basis, and error of the reduced model before each of them."
    return [
        Section(
            "What grows where",
            headline=lambda made: " ".join(first_lines(made)),
            tables=[answer_table(made)],
            plots=[drawing],
        ),
        Section("Warnings", tables=[Table("warnings", "", lambda made: warned(made.record))]),
        Section("Values", tables=[Table("sweep", every, values, own, shown=few)]),
        Section(
            "Full solves",
            tables=[Table("full_solves", basis, full_solves, own)]
            if made.record["snapshots"]
            else [],
        ),
    ]


def _columns(made: Swept) -> dict[str, Column]:
    """Return the columns of sweeps that are not shared: the fields, and a difference."""
    fields = {name: Column(name, show="{:.10g}".format) for name in made.points.names}
    return fields | {"full": Column("full solve differs by", show=shown(2, sign=True))}


def answer_table(made: Swept) -> Table:
    """Return the table of thresholds, or of probabilities for samples."""
    data = made.record
    if not made.points.axes:
        caption = (
            f"Growing samples of {data['values']}. From low to high: 95 per cent confidence "
            "interval of the probability; growth: 5, 50 and 95 per cent quantiles (1/s)."
        )
        return Table("probability", caption, probability)
    caption = f"Where the number of growing modes changes along {made.points.names[0]}."
    if data["resolution"]:
        caption += f" Widest interval accepted by count alone: {data['resolution']:.1e}."
    return Table("thresholds", caption, thresholds, _columns(made))


def thresholds(made: Swept) -> pd.DataFrame:
    """Return a row for each threshold and each unresolved interval."""
    (first, *others), rows = made.points.names, []
    for each in made.record["thresholds"]:
        what = _WHAT[each["kind"]][each["change"] < 0]
        rows.append(each | {first: each["value"], "bound": each["error"], "what": what})
    for each in made.record["unresolved"]:
        middle, half = (each["high"] + each["low"]) / 2, (each["high"] - each["low"]) / 2
        what = f"unresolved; growing eigenvalues {each['before']} before, {each['after']} after"
        rows.append(each | {first: middle, "bound": half, "what": what})
    columns = [*others, first, "bound", "im", "what", "full_solve_differs"]
    frame = pd.DataFrame(rows, columns=columns)
    frame["im"] = frame["im"].astype(float) / (2 * np.pi)
    return frame.rename(columns={"im": "frequency", "full_solve_differs": "full"})


def full_solves(made: Swept) -> pd.DataFrame:
    """Return a row for each full solve: all parameters, and what it tested."""
    return pd.DataFrame(
        each["point"]
        | {"error over its bound": each["tested"], "window complete": each["complete"]}
        for each in made.record["snapshots"]
    )


def values(made: Swept) -> pd.DataFrame:
    """Return a row for each point: number of growing modes, the fastest, bound, warnings."""
    data, spectra = made.record, made.spectra
    frame = pd.DataFrame(made.points.values, columns=[*made.points.names])
    reasons = {tuple(each["point"].values()): each["reason"] for each in data["failed"]}
    top = np.arange(len(frame)), np.where(spectra.there, spectra.growth, -np.inf).argmax(axis=1)
    points = frame.to_dict("records")
    return frame.assign(
        modes=spectra.there.sum(axis=1),
        **{
            word.replace(" ", "_"): (spectra.verdict == WORDS.index(word)).sum(axis=1)
            for word in GROWING
        },
        growth=spectra.growth[top],
        frequency=spectra.frequency[top],
        bound=np.nan if "why" in data else spectra.bound,
        warnings=[", ".join(kinds_at(data.get("warnings", ()), at)) for at in points],
        no_answer=[reasons.get(tuple(at.values()), "") for at in points],
    )


def probability(made: Swept) -> pd.DataFrame:
    """Return a row for all modes together, and one for each mode that may grow."""
    data = made.record
    together = {"mode": "any", "frequency": None, "seen": data["values"]} | data["any"]
    return pd.json_normalize([together, *data["modes"]], sep="_")


def line_figure(made: Swept) -> Figure:
    """Growth rates and frequencies of all modes over each field; unstable ones in colour."""
    data, points, spectra = made.record, made.points, made.spectra
    count, end = len(points.names), data["max_frequency"]
    figure = Figure(figsize=(3.6 + 3.6 * count, 6.4), layout="constrained")
    panels = figure.subplots(2, count, sharex="col", sharey="row", squeeze=False)
    panels[0, 0].set_ylabel("growth rate (1/s)")
    panels[1, 0].set_ylabel("frequency (Hz)")
    unstable = spectra.verdict == UNSTABLE
    for name, scale, drawn, (growth, frequency) in zip(
        points.names, _scales(data), points.values.T, panels.T, strict=True
    ):
        values = np.broadcast_to(drawn[:, None], spectra.growth.shape)
        for space, rates in ((growth, spectra.growth), (frequency, spectra.frequency)):
            for chosen, colour, size in ((~unstable, GREY, 1.5), (unstable, VERMILION, 4.0)):
                space.plot(values[chosen], rates[chosen], ".", color=colour, ms=size)
            for each in data["unresolved"]:
                space.axvspan(each["low"], each["high"], hatch="///", alpha=0.2, color=GREY)
        for each in data["thresholds"]:
            at, height = each["value"], each["im"] / (2 * np.pi)
            frequency.errorbar(at, height, xerr=each["error"], fmt="o", color=BLUE, ms=4)
            growth.axvline(at, color=AXIS, linewidth=0.5, linestyle=":")
        growth.axhline(0.0, color=AXIS, linewidth=0.8)
        frequency.axhline(end, color=AXIS, linewidth=0.8, linestyle="--")
        frequency.axhspan(end, HINT * end, color=GREY, alpha=0.2)
        frequency.set(xlabel=name, xscale=scale)
    return figure


line_figure.__name__ = "sweep"


def map_figure(made: Swept) -> Figure:
    """Largest growth rate over the first two axes.

    White: no growth above the threshold. Dots: growth begins; crosses: it ends. Hatched: a mode
    grows just above the window. Grey crosses: not certified.
    """
    data, points, spectra = made.record, made.points, made.spectra
    x, y = points.axes[:2]

    def plane(values: np.ndarray) -> np.ndarray:
        first: np.ndarray = values.reshape(*points.counts[:2], -1)[:, :, 0].T
        return first

    figure = Figure(figsize=(7.2, 4.8), layout="constrained")
    space = figure.subplots()
    growth = np.ma.masked_invalid(plane(spectra.largest))
    mesh = space.pcolormesh(x, y, growth, cmap="viridis", shading="nearest", rasterized=True)
    figure.colorbar(mesh, label="largest growth rate of an unstable mode (1/s)")
    further = {axis["name"]: axis["values"][0] for axis in data["axes"][2:]}
    here = [t for t in data["thresholds"] if all(t[n] == v for n, v in further.items())]
    for begins, look in ((True, "o"), (False, "x")):
        of_kind = [each for each in here if (each["change"] > 0) == begins]
        at = [each["value"] for each in of_kind], [each[points.names[1]] for each in of_kind]
        space.plot(*at, look, color=VERMILION, ms=2.5)
    xscale, yscale = _scales(data)[:2]
    space.set(xlabel=points.names[0], ylabel=points.names[1], xscale=xscale, yscale=yscale)
    row, column = np.nonzero(plane(spectra.bound) > data["inputs"]["tolerance"])
    space.plot(x[column], y[row], "+", color=GREY, ms=4)
    above = np.isfinite(plane(spectra.above_growth))
    if above.any():
        hatched = np.ma.masked_where(~above, np.ones(above.shape))
        space.pcolor(x, y, hatched, shading="nearest", hatch="///", alpha=0.0)
    return figure


map_figure.__name__ = "map"


def _scales(data: Data) -> list[str]:
    """Return the scales of plots over each field."""
    return ["log" if field.get("log") else "linear" for field in data["inputs"]["fields"]]
