"""The record of a command in the folder of its report, and how it is opened again.

``RESULT`` is its file: everything computed; tables, figures and words are drawn from it.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cea.errors import InputError
from scenes.results.folder import RESULT as RESULT
from scenes.results.record import read_record


def read_result(out: Path, command: str) -> dict[str, Any]:
    """Record that a command wrote to a folder, as it is or compressed.

    Raises
    ------
    InputError
        When the folder holds none of that command.
    """
    files = (out / RESULT, out / f"{RESULT}.gz")
    found = next((file for file in files if file.is_file()), None)
    data = read_record(found) if found is not None else {}
    if data.get("command") != command:
        raise InputError("out", str(out), f"a folder with the {RESULT} of `cea {command}`")
    return data


def last_seconds(out: Path, command: str, inputs: Mapping[str, Any] | None = None) -> float | None:
    """How long a command took that wrote its record to a folder before.

    Parameters
    ----------
    out
        The folder.
    command
        The command.
    inputs
        What it must have been given for its time to tell something; None takes any.

    Returns
    -------
    float or None
        Seconds; None where there is no such record.
    """
    try:
        data = read_result(out, command)
    except (InputError, OSError):  # a path may be too long to look at
        return None
    seconds = data.get("seconds")
    alike = inputs is None or data.get("inputs") == dict(inputs)
    return float(seconds) if alike and isinstance(seconds, int | float) else None
