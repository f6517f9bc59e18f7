"""The record of a command in the folder of its report, and how it is opened again.

``RESULT`` is its file: everything computed; tables, figures and words are drawn from it.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cea.errors import InputError
from scenes.results.folder import RESULT as RESULT
from scenes.results.record import read_record

Data = Mapping[str, Any]
"""Plain data, as JSON holds them."""


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
