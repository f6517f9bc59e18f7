"""What a sweep leaves behind: sweep.nc, tables, pictures, the page that holds them, the record."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cea.petsc import MPI
from comparisons.kit.page import REPORT, Image, write_page
from comparisons.kit.plots import save
from comparisons.kit.records import read_result
from comparisons.sweep.figures import line_figure, map_figure, samples_figure
from comparisons.sweep.points import Points
from comparisons.sweep.spectra import read_netcdf, write_netcdf
from comparisons.sweep.study import COMMAND, Swept
from comparisons.sweep.tables import (
    growing_samples,
    headline,
    tables_of,
    words_where_most_grows,
)

TEMPLATE = Path(__file__).with_name("sweep.html")
FILE = "sweep.nc"
_LINES = 3
"""Lines of a map of two axes or more whose modes are drawn."""
_ON_PAGE = 500
"""Rows of a table that the page holds; its file holds all."""


def write_sweep(made: Swept, out: Path) -> Path:
    """Write a sweep to a folder, on rank 0.

    Returns
    -------
    Path
        The page to open.
    """
    if MPI.COMM_WORLD.rank:
        return out / REPORT
    out.mkdir(parents=True, exist_ok=True)
    write_netcdf(made.spectra, made.points, out / FILE)
    tables = tables_of(made.record, made.points, made.spectra)
    pictures = _draw(made, out)
    told = made.record | {
        "headline": headline(made.record),
        "words": words_where_most_grows(made.record, made.points, made.spectra),
    }
    shown = [replace(table, rows=table.rows[:_ON_PAGE]) for table in tables]
    page = write_page(TEMPLATE, told, shown, out, images=[Image.of(file) for file in pictures])
    for table in tables:
        table.write_csv(out)
    return page


def _draw(made: Swept, out: Path) -> list[Path]:
    """Pictures of a line; of a map that of growth, and of a few lines; of samples."""
    data, points, spectra = made.record, made.points, made.spectra
    drawn: dict[str, Any] = {"data": data, "points": points, "spectra": spectra}
    if not points.counts:
        save(samples_figure(drawn | {"largest": growing_samples(data, spectra)}), out / "sweep.png")
        return [out / "sweep.png"]
    lines = np.arange(len(points.values)).reshape(points.counts[0], -1).T
    if len(lines) == 1:
        save(line_figure(drawn | {"line": lines[0], "at": ""}), out / "sweep.png")
        return [out / "sweep.png"]
    save(map_figure(drawn), out / "map.png")
    files = [out / "map.png"]
    chosen = np.unique(np.linspace(0, len(lines) - 1, _LINES).round().astype(int))
    for number, line in enumerate(lines[chosen], 1):
        at = zip(points.names[1:], points.values[line[0], 1:], strict=True)
        told = " at " + ", ".join(f"{name} = {value:.4g}" for name, value in at)
        files.append(out / f"line_{number}.png")
        save(line_figure(drawn | {"line": line, "at": told}), files[-1])
    return files


def read_sweep(out: Path) -> Swept:
    """A sweep that was written; refused where the folder holds none."""
    data = read_result(out, COMMAND)
    if "axes" in data:
        grid = np.meshgrid(*(axis["values"] for axis in data["axes"]), indexing="ij")
        names = tuple(axis["name"] for axis in data["axes"])
        logarithmic = bool(data["inputs"]["fields"][0]["log"])
        values = np.stack([each.ravel() for each in grid], axis=1)
        points = Points(names, values, grid[0].shape, logarithmic)
    else:
        import xarray

        names = tuple(field["name"] for field in data["fields"])
        with xarray.open_dataset(out / FILE, engine="h5netcdf") as opened:
            values = np.stack([np.array(opened[name]) for name in names], axis=1)
        points = Points(names, values, cut=tuple(field["cut"] for field in data["fields"]))
    return Swept(data, points, read_netcdf(points, out / FILE), None)
