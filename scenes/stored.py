"""One stored form of what any command computed, and how it is opened again.

A record is plain data: ``command`` and its ``inputs``, ``versions``, ``commit`` and ``machine``
that made it, ``seconds``, ``warnings``, and beside them the data of the command. Infinity, which
JSON has no number for, is stored as the text "inf".
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
from math import inf, isinf
from pathlib import Path
from typing import Any

from cea.errors import InputError

PROVENANCE = ("command", "inputs", "versions", "commit", "machine", "seconds", "warnings")
"""Fields of every record; what else it holds is data of its command."""

_PACKAGE = "friction-cea"
_PACKAGES = {
    "dolfinx": "dolfinx-solver-real",
    "gmsh": "gmsh",
    "numpy": "numpy",
    "scipy": "scipy",
    "pyvista": "pyvista",
    _PACKAGE: _PACKAGE,
}
_LEVEL = 6
"""Level of compression: the highest takes three times as long and saves a few per cent."""
_INFINITIES = {"inf": inf, "-inf": -inf}


def record(
    command: str,
    data: Mapping[str, Any],
    *,
    inputs: Mapping[str, Any],
    seconds: float,
    warnings: Iterable[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """What a command computed with all that tells where it comes from.

    Parameters
    ----------
    command
        Name of the command.
    data
        What it computed, plain data.
    inputs
        What it was given, plain data.
    seconds
        How long it took.
    warnings
        What a reader must know, each as plain data.

    Raises
    ------
    InputError
        When a field of the data has a name of the provenance.
    """
    taken = [name for name in data if name in PROVENANCE]
    if taken:
        raise InputError("data", taken, f"other names than {', '.join(PROVENANCE)}")
    return {
        "command": command,
        "inputs": dict(inputs),
        "versions": versions(),
        "commit": commit(),
        "machine": machine(),
        "seconds": seconds,
        "warnings": [dict(warning) for warning in warnings],
        **data,
    }


def write_record(data: Mapping[str, Any], file: Path) -> Path:
    """Write plain data as JSON, whole or not at all, making its folder.

    Parameters
    ----------
    data
        The data.
    file
        The file; with the ending ``.gz`` it is compressed.
    """
    compressed = file.suffix == ".gz"
    layout: dict[str, Any] = {"separators": (",", ":")} if compressed else {"indent": 1}
    text = json.dumps(in_json(data), allow_nan=False, **layout)
    return write_whole(f"{text}\n".encode(), file)


def write_whole(content: bytes, file: Path) -> Path:
    """Write a file whole or not at all, making its folder.

    Parameters
    ----------
    content
        What it holds.
    file
        The file; with the ending ``.gz`` it is compressed, the same bytes for the same content.
    """
    if file.suffix == ".gz":
        content = gzip.compress(content, _LEVEL, mtime=0)
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        part.write_bytes(content)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
    return file


def read_record(file: str | Path) -> dict[str, Any]:
    """Read what :func:`write_record` wrote.

    Raises
    ------
    InputError
        When there is no such file, or no such data in it.
    """
    path = Path(file)
    try:
        content = path.read_bytes()
        data = json.loads(gzip.decompress(content) if path.suffix == ".gz" else content)
    except (OSError, EOFError, zlib.error, ValueError) as error:
        raise InputError("file", str(file), f"a stored result: {error}") from error
    if not isinstance(data, dict):
        raise InputError("file", str(file), "a stored result, which is a table of fields")
    return _from_json(data)


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that matter for numbers."""
    from cea.petsc import PETSc, SLEPc

    found = {"python": platform.python_version()}
    for name, package in _PACKAGES.items():
        try:
            found[name] = version(package)
        except PackageNotFoundError:
            found[name] = "not installed as a package"
    for name, system in (("petsc", PETSc.Sys), ("slepc", SLEPc.Sys)):
        found[name] = ".".join(map(str, system.getVersion()))
    return found


@cache
def commit() -> str:
    """Commit of the program where it runs from a checkout, else the version of its package.

    A commit with changes that are not committed ends in ``-dirty``.
    """
    root = Path(__file__).parents[1]
    if (root / ".git").exists():
        command = ("git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40")
        try:
            done = subprocess.run(
                [*command, "--exclude=*"], capture_output=True, text=True, check=True
            )
            return done.stdout.strip()
        except (OSError, subprocess.CalledProcessError):
            pass  # no git, or a checkout of another owner: the package says what it is
    try:
        return f"{_PACKAGE} {version(_PACKAGE)}"
    except PackageNotFoundError:
        return "unknown"


def machine() -> dict[str, Any]:
    """Processor count and kind."""
    return {"cpus": os.cpu_count(), "machine": platform.machine(), "system": platform.system()}


def in_json(value: Any) -> Any:
    """Plain data in which infinity is the text "inf"."""
    if isinstance(value, Mapping):
        return {key: in_json(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [in_json(part) for part in value]
    return str(value) if isinstance(value, float) and isinf(value) else value


def _from_json(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _from_json(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_from_json(part) for part in value]
    return _INFINITIES.get(value, value) if isinstance(value, str) else value
