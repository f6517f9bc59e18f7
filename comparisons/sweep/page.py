"""What a sweep leaves behind: sweep.nc, tables, pictures, the page that holds them, the record."""

from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cea.arrays import Ints
from cea.petsc import MPI
from comparisons.study.page import REPORT, write
from comparisons.study.plots import AXIS, BLUE, GREY, VERMILION
from comparisons.study.result import RESULT, Data, read_result
from comparisons.study.sections import Drawing
from comparisons.sweep.points import Points
from comparisons.sweep.spectra import HINT, UNSTABLE, read_netcdf, write_netcdf
from comparisons.sweep.study import COMMAND, Swept
from comparisons.sweep.tables import sections_of
from scenes.results.record import write_record

FILE = "sweep.nc"
_LINES = 3
"""Lines of a map of two axes or more whose modes are drawn."""
_MODES = 25
"""Modes whose probability is drawn: the most probable ones."""


def write_sweep(made: Swept, out: Path) -> Path:
    """Write a sweep to a folder, on rank 0; the page to open."""
    if MPI.COMM_WORLD.rank:
        return out / REPORT
    out.mkdir(parents=True, exist_ok=True)
    write_netcdf(made.spectra, made.points, out / FILE)
    write_record(made.record, out / RESULT)
    title = f"Sweep of {made.record['inputs']['scene']}"
    return write(title, sections_of(made, _drawings(made.points)), made, out)


def _drawings(points: Points) -> list[Drawing]:
    """Pictures of a line; of a map that of growth, and of a few lines; of samples."""
    if not points.axes:
        return [samples_figure]
    lines = points.lines
    chosen = np.unique(np.linspace(0, len(lines) - 1, _LINES).round().astype(int))
    drawn: list[Drawing] = [] if len(lines) == 1 else [map_figure]
    for number, line in enumerate(lines[chosen], 1):
        figure = partial(line_figure, line=line)
        figure.__name__ = "sweep" if len(lines) == 1 else f"line_{number}"  # type: ignore[attr-defined]
        drawn.append(figure)
    return drawn


def read_sweep(out: Path) -> Swept:
    """A sweep that was written; refused where the folder holds none."""
    data = read_result(out, COMMAND)
    grid, told = "axes" in data, data.get("axes") or data["fields"]
    names = tuple(each["name"] for each in told)
    values, spectra = read_netcdf(names, out / FILE, grid=grid)
    if grid:
        points = Points.of_axes(names, values, log=bool(data["inputs"]["fields"][0]["log"]))
    else:
        cut = tuple(field["cut"] for field in told)
        points = Points(names, np.stack(values, axis=1), cut=cut)
    return Swept(data, points, spectra, None)


def line_figure(made: Swept, line: Ints) -> Figure:
    """Growth and frequency of all modes along the first axis, unstable ones in colour."""
    data, points, spectra = made.record, made.points, made.spectra
    figure = Figure(figsize=(7.2, 6.4), layout="constrained")
    growth, frequency = figure.subplots(2, 1, sharex=True)
    values = np.broadcast_to(points.values[line, :1], spectra.growth[line].shape)
    unstable = spectra.verdict[line] == UNSTABLE
    for space, shown in ((growth, spectra.growth), (frequency, spectra.frequency)):
        for chosen, colour, size in ((~unstable, GREY, 1.5), (unstable, VERMILION, 4.0)):
            space.plot(values[chosen], shown[line][chosen], ".", color=colour, ms=size)
        for each in data["unresolved"]:
            if _of(points, line, each):
                space.axvspan(each["low"], each["high"], hatch="///", alpha=0.2, color=GREY)
        if points.logarithmic:
            space.set_xscale("log")
    for each in data["thresholds"]:
        if _of(points, line, each):
            at, height = each["value"], each["im"] / (2 * np.pi)
            frequency.errorbar(at, height, xerr=each["error"], fmt="o", color=BLUE, ms=4)
            growth.axvline(at, color=AXIS, linewidth=0.5, linestyle=":")
    growth.axhline(0.0, color=AXIS, linewidth=0.8)
    growth.set_ylabel("growth rate (1/s)")
    frequency.set_ylabel("frequency (Hz)")
    frequency.set_xlabel(points.names[0])
    if (end := data["max_frequency"]) is not None:
        frequency.axhline(end, color=AXIS, linewidth=0.8, linestyle="--")
        frequency.axhspan(end, HINT * end, color=GREY, alpha=0.2)
    others = zip(points.names[1:], points.values[line[0], 1:], strict=True)
    at = ", ".join(f"{name} = {value:.4g}" for name, value in others)
    growth.set_title(f"Modes along {points.names[0]}{' at ' if at else ''}{at}")
    return figure


def _of(points: Points, line: np.ndarray, told: Data) -> bool:
    """Whether a threshold or an interval is of a line."""
    at = points.values[line[0], 1:].tolist()
    return all(told[name] == value for name, value in zip(points.names[1:], at, strict=True))


def map_figure(made: Swept) -> Figure:
    """Largest growth over the first two axes.

    White: no growth above the threshold. Dots: growth begins; crosses: it ends. Hatched: a mode
    grows just above the window. Grey crosses: not certified.
    """
    data, points, spectra = made.record, made.points, made.spectra
    x, y = points.axes[:2]

    def shown(values: np.ndarray) -> np.ndarray:
        plane: np.ndarray = values.reshape(*points.counts[:2], -1)[:, :, 0].T
        return plane

    figure = Figure(figsize=(7.2, 4.8), layout="constrained")
    space = figure.subplots()
    growth = np.ma.masked_invalid(shown(spectra.largest))
    mesh = space.pcolormesh(x, y, growth, cmap="viridis", shading="nearest", rasterized=True)
    figure.colorbar(mesh, label="largest growth rate of an unstable mode (1/s)")
    further = {axis["name"]: axis["values"][0] for axis in data["axes"][2:]}
    here = [t for t in data["thresholds"] if all(t[n] == v for n, v in further.items())]
    for begins, look in ((True, "o"), (False, "x")):
        of_kind = [each for each in here if (each["change"] > 0) == begins]
        at = [each["value"] for each in of_kind], [each[points.names[1]] for each in of_kind]
        space.plot(*at, look, color=VERMILION, ms=2.5)
    if points.logarithmic:
        space.set_xscale("log")
    if (y > 0).all() and y.max() > 20 * y.min():
        space.set_yscale("log")
    space.set_xlabel(points.names[0])
    space.set_ylabel(points.names[1])
    tolerance = data["inputs"]["tolerance"]
    row, column = np.nonzero(shown(spectra.bound) > tolerance)
    space.plot(x[column], y[row], "+", color=GREY, ms=4)
    above = np.isfinite(shown(spectra.above_growth))
    if above.any():
        hatched = np.ma.masked_where(~above, np.ones(above.shape))
        space.pcolor(x, y, hatched, shading="nearest", hatch="///", alpha=0.0)
    return figure


map_figure.__name__ = "map"


def samples_figure(made: Swept) -> Figure:
    """Probabilities with their intervals, and where samples grow over each field."""
    data, points, largest = made.record, made.points, made.spectra.largest
    count = len(points.names) + 1
    figure = Figure(figsize=(9.4, 3.2 * ((count + 1) // 2)), layout="constrained")
    spaces = figure.subplots((count + 1) // 2, 2, squeeze=False).ravel()
    _bars(spaces[0], data)
    grows = np.isfinite(largest)
    for space, name, values in zip(spaces[1:], points.names, points.values.T, strict=False):
        space.plot(values[~grows], np.zeros((~grows).sum()), ".", color=GREY, ms=2)
        space.plot(values[grows], largest[grows], ".", color=VERMILION, ms=2)
        if values.min() > 0 and values.max() > 20 * values.min():
            space.set_xscale("log")
        space.set_xlabel(name)
        space.set_ylabel("largest growth rate (1/s)")
    for space in spaces[count:]:
        space.remove()
    return figure


samples_figure.__name__ = "sweep"


def _bars(space: Axes, data: Data) -> None:
    modes = sorted(data["modes"], key=lambda each: -each["probability"])[:_MODES]
    modes.sort(key=lambda each: each["frequency"])
    shown = [*modes, data["any"]]
    share = np.array([each["probability"] for each in shown])
    ends = np.array([[each["low"], each["high"]] for each in shown]).T
    # An interval may leave its share out where samples are undecided.
    errors = np.maximum([share - ends[0], ends[1] - share], 0.0)
    colours = [BLUE] * len(modes) + [VERMILION]
    space.barh(np.arange(len(shown)), share, color=colours, xerr=errors, ecolor=AXIS)
    names = [f"{each['frequency']:,.0f} Hz".replace(",", "\u202f") for each in modes]
    space.set_yticks(np.arange(len(shown)), [*names, "any"])
    space.set_xlim(0, 1)
    space.set_xlabel("probability of growth, intervals of 95 %")
