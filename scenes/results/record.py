"""Records: the stored form of the results of all commands.

A record is plain data: ``command`` and its ``inputs``, ``versions``, ``commit``, ``machine``,
``seconds``, ``warnings``, and the data of the command. Infinity, which JSON does not have, is
stored as the text "inf"; the text "inf" itself, possibly with backslashes before it, is stored
with another backslash.
"""

import gzip
import json
import os
import platform
import subprocess
import zlib
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from math import inf, isinf, isnan
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ValidationError

from cea.eigen.spectrum import Spectrum, Window
from cea.errors import InputError, ResultWarning, require
from cea.files import regular, write_whole
from cea.timing import StageTimer
from scenes.results.result import Result
from scenes.spec.problems import problems
from scenes.spec.reading import read_scene


class Eigenvalue(BaseModel):
    """Fields of an eigenvalue that are read back from a record."""

    re: float
    im: float
    residual: float
    condition: float
    uncertainty: float
    bounded: bool = False


class SideStress(BaseModel):
    """Normal stress of one side of a contact."""

    min: float
    max: float
    arc: list[float]
    sigma_n_along: list[float | None]


class Dofs(BaseModel):
    """Number of unknowns."""

    free: int


class RunRecord(BaseModel):
    """Fields of the record of a run (`docs/result_json.md`) that are needed to open it."""

    command: str
    inputs: dict[str, Any]
    versions: dict[str, str]
    commit: str
    machine: dict[str, Any]
    seconds: float
    scene: dict[str, Any]
    dofs: Dofs
    timings: dict[str, float]
    skipped: dict[str, str]
    warnings: tuple[ResultWarning, ...]
    eigenvalues: list[Eigenvalue] | None = None
    window: Window | None = None
    stresses: dict[str, dict[str, SideStress]] | None = None


PROVENANCE = ("command", "inputs", "versions", "commit", "machine", "seconds", "warnings")
"""Fields of every record; all others are data of its command."""
RUN = "run"
"""Value of ``command`` in the record of a run."""

_PACKAGE = "friction-cea"
_PACKAGES = {
    "dolfinx": "dolfinx-solver-real",
    "gmsh": "gmsh",
    "numpy": "numpy",
    "scipy": "scipy",
    "pyvista": "pyvista",
    _PACKAGE: _PACKAGE,
}
_INFINITIES = {"inf": inf, "-inf": -inf}


def save_result(
    result: Result,
    file: str | Path,
    *,
    inputs: Mapping[str, Any] | None = None,
    data: Mapping[str, Any] | None = None,
) -> Path:
    """Write the record of a run, which :func:`scenes.open_result` opens; collective.

    Parameters
    ----------
    result
        Result of the run.
    file
        File to write, on rank 0.
    inputs
        Inputs of the command; by default the name of the scene.
    data
        Additional data to store.

    Raises
    ------
    InputError
        If the result was read back from a record.
    """
    require(not result.record, "result", result.scene.name, "a fresh run, not one read back")
    path, described = Path(file), dict(result.data)
    seconds = described.pop("seconds")
    if result.comm.rank == 0:
        inputs = {"scene": result.scene.name} if inputs is None else inputs
        described |= data or {}
        warnings = [warning.plain() for warning in result.warnings]
        made = record(RUN, described, inputs=inputs, seconds=seconds, warnings=warnings)
        write_record(made, path)
    return path


def open_result(file: str | Path) -> Result:
    """Open the record of a run.

    Parameters
    ----------
    file
        A ``result.json``, compressed if its name ends in ``.gz``.

    Raises
    ------
    InputError
        If the file does not exist or is not the record of a run.
    """
    data = read_record(file)
    try:
        record = RunRecord.model_validate_json(json.dumps(data), strict=True)
    except ValidationError as error:
        first = problems(error, data, {})[0]
        raise InputError("file", str(file), f"a stored result; invalid field {first}") from error
    from scenes.spec.matrices import read_matrix_scene

    read: Any = read_matrix_scene if "files" in record.scene else read_scene
    scene, timer = read(record.scene), StageTimer()
    timer.seconds = record.timings
    return Result(
        scene,
        timer,
        record.skipped,
        record.warnings,
        **_opened(record, scene.analysis.kind),
        record=data,
    )


def _opened(record: RunRecord, kind: str) -> dict[str, Any]:
    """Return the eigenvalues or stresses of a record as keyword arguments of a result."""
    if record.stresses is not None and kind == "static":
        from cea.system.contact_stresses import NormalStress

        stresses: dict[str, dict[str, Any]] = {name: {} for name in record.stresses}
        for name, sides in record.stresses.items():
            for side, s in sides.items():
                along = np.array(s.sigma_n_along, dtype=float)
                stresses[name][side] = NormalStress(s.min, s.max, np.array(s.arc), along)
        return {"stresses": stresses}
    values, window = record.eigenvalues, record.window
    if values is None or window is None or kind == "static":
        allowed = "'cea'" if values is not None else "'static'"
        raise InputError("scene.analysis.kind", kind, f"{allowed}, the kind of the stored data")
    rows = np.array([list(value.model_dump().values()) for value in values], dtype=float)
    columns = rows.reshape(len(values), len(Eigenvalue.model_fields)).T
    re, im, residuals, conditions, uncertainties, bounded = columns
    errors = residuals, conditions, uncertainties
    about: Any = {"bounded": bounded.astype(bool), "warnings": record.warnings}
    return {"spectrum": Spectrum(re + 1j * im, *errors, window, **about)}


def record(
    command: str,
    data: Mapping[str, Any],
    *,
    inputs: Mapping[str, Any],
    seconds: float,
    warnings: Iterable[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """Return the record of a command: its data with the provenance."""
    taken = [name for name in data if name in PROVENANCE]
    require(not taken, "data", taken, f"other names than {', '.join(PROVENANCE)}")
    return {
        "command": command,
        "inputs": dict(inputs),
        "versions": versions(),
        "commit": commit(),
        "machine": {
            "cpus": os.cpu_count(),
            "machine": platform.machine(),
            "system": platform.system(),
        },
        "seconds": seconds,
        "warnings": [dict(warning) for warning in warnings],
        **data,
    }


def write_record(data: Mapping[str, Any], file: Path) -> Path:
    """Write plain data as JSON atomically, compressed if the file name ends in ``.gz``."""
    return write_whole(f"{as_json(data, compact=file.suffix == '.gz')}\n".encode(), file)


def as_json(data: Mapping[str, Any], *, compact: bool = False) -> str:
    """Return plain data as JSON; ``compact`` omits spaces and line breaks."""
    layout: dict[str, Any] = {"separators": (",", ":")} if compact else {"indent": 1}
    return json.dumps(_in_json(data), allow_nan=False, **layout)


def read_record(file: str | Path) -> dict[str, Any]:
    """Read a file of :func:`write_record`; raise an InputError for other files."""
    path = Path(file)
    try:
        with (gzip.open if path.suffix == ".gz" else open)(regular(path), "rb") as stream:
            data = json.load(stream, parse_constant=_no_number)
    except (OSError, EOFError, zlib.error, ValueError, RecursionError) as error:
        raise InputError("file", str(file), f"a stored result: {error}") from error
    if not isinstance(data, dict):
        raise InputError("file", str(file), "a stored result, which is a table of fields")
    return _from_json(data)


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that affect numerical results."""
    from cea.petsc import PETSc, SLEPc

    found = {name: _version(package) for name, package in _PACKAGES.items()}
    for name, system in (("petsc", PETSc.Sys), ("slepc", SLEPc.Sys)):
        found[name] = ".".join(map(str, system.getVersion()))
    return {"python": platform.python_version(), **found}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed as a package"


@cache
def commit() -> str:
    """Return the commit of the checkout of the program, or the version of the package.

    With uncommitted changes the commit ends in ``-dirty``. No git locks are taken, so that the user
    can commit at the same time.
    """
    root = Path(__file__).parents[2]
    git = ["git", "--no-optional-locks", "-C", str(root), "describe", "--always", "--dirty"]
    options = ["--abbrev=40", "--exclude=*"]
    try:
        if (root / ".git").exists():
            done = subprocess.run([*git, *options], capture_output=True, text=True, check=True)
            return done.stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        pass  # no git, or a checkout of another owner: use the package version
    return f"{_PACKAGE} {_version(_PACKAGE)}"


def _in_json(value: Any, place: str = "data") -> Any:
    """Return plain data with infinity as the text "inf"; raise an InputError for NaN."""
    if isinstance(value, Mapping):
        return {key: _in_json(part, f"{place}.{key}") for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_in_json(part, f"{place}.{i}") for i, part in enumerate(value)]
    if isinstance(value, float):
        if isnan(value):
            raise InputError(place, value, "a number: JSON has none for it")
        return str(value) if isinf(value) else value
    infinite = isinstance(value, str) and value.lstrip("\\") in _INFINITIES
    return f"\\{value}" if infinite else value


def _from_json(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _from_json(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_from_json(part) for part in value]
    if isinstance(value, str) and value.lstrip("\\") in _INFINITIES:
        return _INFINITIES.get(value, value[1:])
    return value


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is no JSON")
