"""Maps as netCDF files, which xarray and most programs of the sciences read."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from cea.eigen.classify import WORDS
from cea.reduced.crossings import Threshold
from cea.reduced.thresholds import Unresolved
from comparisons.sweep.rows import Row

ENGINE = "h5netcdf"
"""What reads and writes netCDF files."""
INTERVALS = ("thresholds", "unresolved")
"""What rows know of their thresholds."""
_VARIABLES = {
    "growth": ("1/s", "growth rate"),
    "frequency": ("Hz", "frequency"),
    "uncertainty": ("1/s", "bound on the error of lambda"),
    "mean_error": ("1", "bound on the error of the mean where modes coalesce, relative"),
    "branch": ("1", "number of the branch"),
    "verdict": ("1", "verdict"),
    "worst": ("1", "worst error that the basis makes, relative"),
    "growth_slope": ("1/s", "derivative of the growth rate in each axis, in its unit"),
    "frequency_slope": ("Hz", "derivative of the frequency in each axis, in its unit"),
    "above_growth": ("1/s", "fastest growth just above the window's end"),
    "above_frequency": ("Hz", "frequency of that mode"),
}
"""Unit and meaning of what is stored of each mode."""


def write_map(rows: Sequence[Row], axes: Sequence[Mapping[str, Any]], file: Path) -> None:
    """A whole map as one netCDF file, whole or not at all.

    Parameters
    ----------
    rows
        Its rows, the last axis fastest.
    axes
        Name and values of each axis.
    file
        The file.
    """
    import xarray

    names = [each["name"] for each in axes]
    counts = [len(each["values"]) for each in axes]
    modes = max(row.growth.shape[1] for row in rows)
    data: dict[str, Any] = {}
    for name, (unit, about) in _VARIABLES.items():
        parts = []
        for row in rows:
            values = getattr(row, name)
            if values.ndim > 1:
                gone = np.nan if values.dtype.kind == "f" else -1
                wider = ((0, 0), (0, modes - values.shape[1]), *[(0, 0)] * (values.ndim - 2))
                values = np.pad(values, wider, constant_values=gone)
            parts.append(values)
        whole = np.stack(parts, axis=1)
        whole = whole.reshape(*counts, *whole.shape[2:])
        dims = [*names, "mode", "axis"][: whole.ndim]
        data[name] = (dims, whole, {"units": unit, "long_name": about})
    data["verdict"][2].update(
        flag_values=np.arange(len(WORDS), dtype=np.int8),
        flag_meanings=" ".join(word.replace(" ", "_") for word in WORDS),
    )
    coordinates = {each["name"]: each["values"] for each in axes} | {"axis": names}
    write_whole(xarray.Dataset(data, coordinates), file)


def write_whole(dataset: Any, file: Path) -> None:
    """A dataset of xarray as a netCDF file, whole or not at all."""
    part = file.with_suffix(f".{os.getpid()}.part")
    dataset.to_netcdf(part, engine=ENGINE)
    part.replace(file)


def read_map(data: Mapping[str, Any], file: Path) -> list[Row]:
    """Rows of a map that was written, its thresholds from its record.

    Parameters
    ----------
    data
        The record.
    file
        The file.
    """
    import xarray

    first, *others = data["axes"]
    with xarray.open_dataset(file, engine=ENGINE) as opened:
        get = {name: np.array(opened[name]) for name in _VARIABLES}
    count = len(first["values"])
    flat: dict[str, Any] = {
        name: each.reshape(count, -1, *each.shape[len(data["axes"]) :])
        for name, each in get.items()
    }
    places = list(product(*(axis["values"] for axis in others)))
    names = [axis["name"] for axis in others]
    thresholds: dict[tuple[float, ...], list[Threshold]] = {place: [] for place in places}
    unresolved: dict[tuple[float, ...], list[Unresolved]] = {place: [] for place in places}
    for each in data["thresholds"]:
        thresholds[tuple(each[name] for name in names)].append(threshold_of(each))
    for each in data["unresolved"]:
        unresolved[tuple(each[name] for name in names)].append(unresolved_of(each))
    return [
        Row(
            **{name: each[:, i] for name, each in flat.items()},
            thresholds=tuple(thresholds[place]),
            unresolved=tuple(unresolved[place]),
        )
        for i, place in enumerate(places)
    ]


def plain(found: Threshold | Unresolved) -> dict[str, Any]:
    """A threshold or an unresolved interval as plain data; lambda as re and im (1/s)."""
    told = asdict(found)
    root = told.pop("eigenvalue")
    return told | {
        "re": None if root is None else root.real,
        "im": None if root is None else root.imag,
    }


def threshold_of(told: Mapping[str, Any]) -> Threshold:
    """A threshold from plain data."""
    root = complex(told["re"], told["im"])
    names = ("value", "error", "slope", "change", "kind")
    return Threshold(eigenvalue=root, **{name: told[name] for name in names})


def unresolved_of(told: Mapping[str, Any]) -> Unresolved:
    """An unresolved interval from plain data."""
    root = None if told["re"] is None else complex(told["re"], told["im"])
    names = ("low", "high", "before", "after")
    return Unresolved(eigenvalue=root, **{name: told[name] for name in names})
