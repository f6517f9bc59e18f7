"""What a sweep leaves behind: sweep.nc, tables, pictures, the page that holds them, the record."""

from functools import partial
from pathlib import Path

import numpy as np

from cea.petsc import MPI
from comparisons.study.page import REPORT, write
from comparisons.study.result import RESULT, read_result
from comparisons.study.sections import Drawing
from comparisons.sweep.figures import line_figure, map_figure, samples_figure
from comparisons.sweep.points import Points
from comparisons.sweep.spectra import read_netcdf, write_netcdf
from comparisons.sweep.study import COMMAND, Swept
from comparisons.sweep.tables import sections_of
from scenes.results.record import write_record

FILE = "sweep.nc"
_LINES = 3
"""Lines of a map of two axes or more whose modes are drawn."""


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
    if not points.counts:
        return [samples_figure]
    lines = np.arange(len(points.values)).reshape(points.counts[0], -1).T
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
        logarithmic = bool(data["inputs"]["fields"][0]["log"])
        points = Points.of_axes(names, values, logarithmic=logarithmic)
    else:
        cut = tuple(field["cut"] for field in told)
        points = Points(names, np.stack(values, axis=1), cut=cut)
    return Swept(data, points, spectra, None)
