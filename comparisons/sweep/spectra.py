"""Modes at all points of a sweep: arrays, and their netCDF file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.classify import GROWING, WORDS, Word
from cea.reduced.spectrum import ReducedSpectrum
from comparisons.sweep.points import Points
from scenes import Result

UNSTABLE = WORDS.index("unstable")
"""Index of the class in :data:`cea.eigen.classify.WORDS`."""
HINT = 1.05
"""Frequency relative to the end of the window up to which growing modes above it are reported."""
ENGINE = "h5netcdf"
"""Engine of xarray for netCDF files."""


@dataclass(frozen=True)
class Spectra:
    """Modes at points, sorted by frequency; missing entries are NaN or -1.

    Arrays of modes have the shape (points, modes), derivatives (points, modes, fields). ``verdict``
    holds indices in :data:`cea.eigen.classify.WORDS`. ``worst`` is zero for full solves, and NaN
    where one failed; ``above_growth`` and ``above_frequency`` are NaN where no mode grows above the
    window.
    """

    growth: Annotated[Floats, "1/s", "growth rate"]
    frequency: Annotated[Floats, "Hz", "frequency"]
    uncertainty: Annotated[Floats, "1/s", "bound on the error of lambda"]
    mean_error: Annotated[Floats, "1", "bound on the error of the mean of a cluster, relative"]
    verdict: Annotated[NDArray[np.int8], "1", "verdict"]
    worst: Annotated[Floats, "1", "worst error that the basis makes, relative"]
    growth_slope: Annotated[Floats, "1/s", "derivative of growth in each field, in its unit"]
    frequency_slope: Annotated[Floats, "Hz", "derivative of frequency in each field, in its unit"]
    above_growth: Annotated[Floats, "1/s", "fastest growth just above the window's end"]
    above_frequency: Annotated[Floats, "Hz", "frequency of that mode"]
    number: Annotated[Ints, "1", "modes of one number continue each other"]

    @property
    def there(self) -> NDArray[np.bool_]:
        """Mask of the entries that hold a mode, shape (points, modes)."""
        return np.isfinite(self.growth)

    @property
    def bound(self) -> Floats:
        """Largest relative error bound of a cluster's mean at each point, rounding included."""
        return np.fmax.reduce(np.column_stack([self.worst, self.mean_error]), axis=1)

    @property
    def largest(self) -> Floats:
        """Largest growth rate of an unstable mode at each point (1/s); NaN without any."""
        return np.fmax.reduce(np.where(self.verdict == UNSTABLE, self.growth, np.nan), axis=1)

    @classmethod
    def of_rows(cls, rows: Sequence[Mapping[str, Any]]) -> "Spectra":
        """Return the arrays of all points from the rows of single points."""
        most = max(1, *(len(row["growth"]) for row in rows))
        names = [each.name for each in fields(cls)]
        return cls(**{name: np.stack([_padded(row[name], most) for row in rows]) for name in names})


def row_of_model(
    found: ReducedSpectrum, slopes: Complexes, numbers: Ints, threshold: float | None
) -> dict[str, Any]:
    """Return the row of a point of a reduced model; ``slopes`` have the shape (modes, fields)."""
    words, window, end = found.words(threshold), found.window, found.looked_at.end
    above = (found.eigenvalues.imag > end) & (found.eigenvalues.imag <= HINT * end)
    above &= np.isin(words, GROWING)
    inside = np.flatnonzero(found.inside)
    own = [words[i] for i in inside]
    row = _row(window.eigenvalues, window.uncertainties, own, found.eigenvalues[above])
    row |= {"mean_error": window.mean_errors, "worst": found.worst, "number": numbers[inside]}
    return row | {"growth_slope": slopes.real, "frequency_slope": slopes.imag / (2 * np.pi)}


def row_of_result(result: Result | None, count: int) -> dict[str, Any]:
    """Return the row of a full solve (None: it failed) with the given number of fields."""
    if result is None:
        nothing: Complexes = np.empty(0, dtype=complex)
        row = _row(nothing, nothing.real, [], nothing) | {"worst": np.nan}
    else:
        errors = result.modes.growth_uncertainties
        words = result.modes.verdicts(result.analysis.growth_threshold)
        above = np.reshape(result.modes.window.growing_above, (-1, 2))
        growing = above[:, 1] + 2j * np.pi * above[:, 0]
        row = _row(result.eigenvalues, errors, words, growing) | {"worst": 0.0}
    n = len(row["growth"])
    row |= {"mean_error": np.full(n, np.nan), "number": np.full(n, -1, dtype=np.int64)}
    return row | dict.fromkeys(("growth_slope", "frequency_slope"), np.full((n, count), np.nan))


def _row(
    values: Complexes, uncertainty: Floats, words: Sequence[Word], above: Complexes
) -> dict[str, Any]:
    """Return the row of one point: its modes, and the fastest growing one above the window."""
    fastest = above[above.real.argmax()] if len(above) else np.nan + 1j * np.nan
    return {
        "growth": values.real,
        "frequency": values.imag / (2 * np.pi),
        "uncertainty": uncertainty,
        "verdict": np.array([WORDS.index(word) for word in words], dtype=np.int8),
        "above_growth": fastest.real,
        "above_frequency": fastest.imag / (2 * np.pi),
    }


def _padded(known: Any, count: int) -> NDArray[Any]:
    """Return a scalar of a point, or an array of its modes padded to ``count`` with NaN or -1."""
    array = np.asarray(known)
    if array.ndim == 0:
        return array
    gone = np.nan if array.dtype.kind == "f" else -1
    further = ((0, count - len(array)), *[(0, 0)] * (array.ndim - 1))
    return np.pad(array, further, constant_values=gone)


def write_netcdf(spectra: Spectra, points: Points, file: Path) -> None:
    """Write all modes to one netCDF file.

    Axes are dimensions; samples have one dimension "sample", and their fields are variables.
    """
    import xarray

    grid = points.counts or (len(points.values),)
    names = [*points.names] if points.axes else ["sample"]
    data: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"field": list(points.names)}
    for name, hint in get_type_hints(Spectra, include_extras=True).items():
        array, (unit, about) = getattr(spectra, name), hint.__metadata__
        if name == "number" and points.axes:
            continue
        dims = [*names, "mode", "field"][: len(names) + array.ndim - 1]
        shaped = array.reshape(*grid, *array.shape[1:])
        data[name] = (dims, shaped, {"units": unit, "long_name": about})
    data["verdict"][2].update(
        flag_values=np.arange(len(WORDS), dtype=np.int8),
        flag_meanings=" ".join(word.replace(" ", "_") for word in WORDS),
    )
    for i, name in enumerate(points.names):
        if points.axes:
            coordinates[name] = points.axes[i]
        else:
            data[name] = (("sample",), points.values[:, i], {"long_name": "drawn"})
    xarray.Dataset(data, coordinates).to_netcdf(file, engine=ENGINE)


def read_netcdf(file: Path) -> tuple[Points, Spectra]:
    """Read the points and their modes."""
    import xarray

    with xarray.open_dataset(file, engine=ENGINE) as opened:
        names, lead = tuple(opened["field"].values.tolist()), len(opened["worst"].shape)
        values = [np.array(opened[name]) for name in names]
        known = [each.name for each in fields(Spectra) if each.name in opened]
        stored = {name: np.array(opened[name]) for name in known}
        grid = "sample" not in opened.sizes
    flat: dict[str, Any] = {
        name: each.reshape(-1, *each.shape[lead:]) for name, each in stored.items()
    }
    flat.setdefault("number", np.full(flat["growth"].shape, -1, dtype=np.int64))
    points = Points.of_axes(names, values) if grid else Points(names, np.stack(values, axis=1))
    return points, Spectra(**flat)
