"""What samples leave behind: samples.nc, tables, pictures, and the page that holds them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cea.petsc import MPI
from comparisons.kit.page import REPORT, Image, write_page
from comparisons.kit.plots import save
from comparisons.sweep.distributions import Drawn
from comparisons.sweep.netcdf import ENGINE, write_whole
from comparisons.sweep.sample_figures import probability_figure, scatter_figure
from comparisons.sweep.sample_tables import (
    fields_table,
    probability_table,
    samples_summary,
    samples_table,
    solves_table,
)
from comparisons.sweep.sampled import Sampled

TEMPLATE = Path(__file__).with_name("samples.html")
FILE = "samples.nc"
_VARIABLES = {
    "growth": ("1/s", "growth rate"),
    "frequency": ("Hz", "frequency"),
    "uncertainty": ("1/s", "bound on the error of lambda"),
    "number": ("1", "modes of one number continue each other"),
    "grows": ("1", "grows surely, or coalesced with one that does"),
    "may_grow": ("1", "may grow, or coalesced with one that may"),
    "worst": ("1", "worst error that the basis makes, relative"),
    "bound": ("1", "worst error with that of rounding, relative"),
}
"""Unit and meaning of what is stored of each mode."""


def write_samples(data: dict[str, Any], drawn: Sequence[Drawn], found: Sampled, out: Path) -> Path:
    """Write samples to a folder, on rank 0.

    Returns
    -------
    Path
        The page to open.
    """
    if MPI.COMM_WORLD.rank:
        return out / REPORT
    out.mkdir(parents=True, exist_ok=True)
    _write_netcdf(data, drawn, found, out / FILE)
    pictures = {"probability": out / "samples.png", "scatter": out / "fields.png"}
    save(probability_figure({"data": data, "found": found}), pictures["probability"])
    save(scatter_figure({"fields": drawn, "found": found}), pictures["scatter"])
    tables = [
        *(made(data) for made in (probability_table, fields_table, samples_summary, solves_table))
    ]
    if (listed := samples_table(data, drawn, found)) is not None:
        listed.write_csv(out)
    images = {name: Image.of(file) for name, file in pictures.items()}
    return write_page(TEMPLATE, data, tables, out, images=images)


def _write_netcdf(
    data: Mapping[str, Any], drawn: Sequence[Drawn], found: Sampled, file: Path
) -> None:
    """Every mode of every sample, whole or not at all."""
    import xarray

    variables: dict[str, Any] = {
        each.name: (("sample",), each.values, {"long_name": "drawn"}) for each in drawn
    }
    for name, (unit, meaning) in _VARIABLES.items():
        values = getattr(found, name)
        if values.dtype == bool:
            values = values.astype(np.int8)
        dims = ("sample", "mode")[: values.ndim]
        variables[name] = (dims, values, {"units": unit, "long_name": meaning})
    write_whole(xarray.Dataset(variables, attrs={"seed": data["inputs"]["seed"]}), file)


def read_samples(data: Mapping[str, Any], file: Path) -> tuple[tuple[Drawn, ...], Sampled]:
    """What was drawn, and modes of samples that were written.

    Parameters
    ----------
    data
        The record.
    file
        The file.
    """
    import xarray

    with xarray.open_dataset(file, engine=ENGINE) as opened:
        drawn = tuple(
            Drawn(field["name"], opened[field["name"]].values.tolist(), np.empty(0))
            for field in data["fields"]
        )
        get: dict[str, Any] = {name: np.array(opened[name]) for name in _VARIABLES}
    flags = {name: get[name].astype(bool) for name in ("grows", "may_grow")}
    return drawn, Sampled(**(get | flags))
