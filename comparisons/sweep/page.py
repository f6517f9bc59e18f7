"""Output of a sweep: the record, sweep.nc, tables, pictures, and the page with them."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from cea.petsc import MPI
from comparisons.study.page import REPORT, write
from comparisons.study.plots import AXIS, BLUE, GREY, VERMILION
from comparisons.study.result import RESULT, read_result
from comparisons.study.sections import Drawing, Plot
from comparisons.sweep.points import Points
from comparisons.sweep.spectra import HINT, UNSTABLE, read_netcdf, write_netcdf
from comparisons.sweep.study import COMMAND, Swept
from comparisons.sweep.tables import sections_of
from scenes.results.record import write_record

FILE = "sweep.nc"


def write_sweep(made: Swept, out: Path) -> Path:
    """Write a sweep to a folder, on rank 0; return the path of the page."""
    if MPI.COMM_WORLD.rank:
        return out / REPORT
    out.mkdir(parents=True, exist_ok=True)
    write_netcdf(made.spectra, made.points, out / FILE)
    write_record(made.record, out / RESULT)
    title = f"Sweep of {made.record['inputs']['scene']}"
    drawn: Plot | Drawing = SAMPLES
    if made.points.axes:
        drawn = line_figure if len(made.points.axes) == 1 else map_figure
    return write(title, sections_of(made, drawn), made, out)


def read_sweep(out: Path) -> Swept:
    """Read a sweep from a folder; InputError when it holds none."""
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


def line_figure(made: Swept) -> Figure:
    """Draw growth rates and frequencies of all modes along an axis, unstable ones in colour."""
    data, points, spectra = made.record, made.points, made.spectra
    figure = Figure(figsize=(7.2, 6.4), layout="constrained")
    growth, frequency = figure.subplots(2, 1, sharex=True)
    values = np.broadcast_to(points.values, spectra.growth.shape)
    unstable = spectra.verdict == UNSTABLE
    for space, shown in ((growth, spectra.growth), (frequency, spectra.frequency)):
        for chosen, colour, size in ((~unstable, GREY, 1.5), (unstable, VERMILION, 4.0)):
            space.plot(values[chosen], shown[chosen], ".", color=colour, ms=size)
        for each in data["unresolved"]:
            space.axvspan(each["low"], each["high"], hatch="///", alpha=0.2, color=GREY)
        if points.logarithmic:
            space.set_xscale("log")
    for each in data["thresholds"]:
        at, height = each["value"], each["im"] / (2 * np.pi)
        frequency.errorbar(at, height, xerr=each["error"], fmt="o", color=BLUE, ms=4)
        growth.axvline(at, color=AXIS, linewidth=0.5, linestyle=":")
    growth.axhline(0.0, color=AXIS, linewidth=0.8)
    growth.set_ylabel("growth rate (1/s)")
    frequency.set_ylabel("frequency (Hz)")
    frequency.set_xlabel(points.names[0])
    end = data["max_frequency"]
    frequency.axhline(end, color=AXIS, linewidth=0.8, linestyle="--")
    frequency.axhspan(end, HINT * end, color=GREY, alpha=0.2)
    return figure


line_figure.__name__ = "sweep"


def map_figure(made: Swept) -> Figure:
    """Draw the largest growth rate over the first two axes.

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


def _growth_over_fields(made: Swept) -> pd.DataFrame:
    """Return the largest growth rate of each sample (zero if stable) and its values of fields."""
    frame = pd.DataFrame(made.points.values, columns=list(made.points.names))
    grown = frame.assign(growth=np.nan_to_num(made.spectra.largest))
    return grown.melt("growth", var_name="field", value_name="value")


SAMPLES = Plot(
    "sweep",
    "Largest growth rate of an unstable mode over each random field.",
    _growth_over_fields,
    x="value",
    y="growth",
    panel=("field",),
    style="markers",
)
