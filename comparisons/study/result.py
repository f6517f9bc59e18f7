"""Result of a study: a record of its cases, read as data frames and arrays."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from cea.errors import InputError, require
from scenes.results.folder import RESULT as RESULT
from scenes.results.record import read_record, write_record

ARRAYS = "arrays.npz"  # file of the arrays beside the record
Data = Mapping[str, Any]  # plain data, as JSON holds them


@dataclass(frozen=True)
class StudyResult:
    """Result of a study, just run or read from a folder.

    ``record`` has provenance, and ``cases`` with labels, key, commit, seconds, tables of rows and
    so on; names of ``arrays`` begin with the key of their case and a slash.
    """

    record: Data
    arrays: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def cases(self) -> list[dict[str, Any]]:
        """Cases in the order of the study."""
        return self.record["cases"]

    def frame(self, table: str = "runs", **labels: Any) -> pd.DataFrame:
        """Rows of a table of all cases, or of those with given labels; label columns come first."""
        cases = [case for case in self.cases if labels.items() <= case["labels"].items()]
        rows = [c["labels"] | row for c in cases for row in c["tables"].get(table, ())]
        return pd.DataFrame(rows)

    def array(self, case: Mapping[str, Any], name: str) -> np.ndarray:
        """Array that the case with these labels kept; raise an InputError if there is none."""
        for found in self.cases:
            whole = f"{found['key']}/{name}"
            if case.items() <= found["labels"].items() and whole in self.arrays:
                return self.arrays[whole]
        raise InputError("array", name, f"one that the case {dict(case)} kept")

    def failed(self) -> pd.DataFrame:
        """Failed cases, and the reasons."""
        return pd.DataFrame(
            [case["labels"] | {"reason": case["failed"]} for case in self.cases if case["failed"]]
        )

    def runs(self) -> list[dict[str, Any]]:
        """Records of every run of a scene: size, times, warnings, what was left out."""
        return [run for case in self.cases for run in case["runs"]]

    def save(self, out: Path) -> None:
        """Write record and arrays to a folder."""
        write_record(self.record, out / RESULT)
        write_arrays(self.arrays, out / ARRAYS)


def write_arrays(arrays: Mapping[str, np.ndarray], file: Path) -> None:
    """Write arrays, if there are any; equal arrays give equal files."""
    if arrays:
        file.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(file, allow_pickle=False, **arrays)


def read_arrays(file: Path) -> dict[str, np.ndarray]:
    """Arrays of a file; none if there is no file."""
    if not file.is_file():
        return {}
    with np.load(file, allow_pickle=False) as stored:
        return {name: stored[name] for name in stored.files}


def read_result(out: Path, command: str) -> dict[str, Any]:
    """Read the record that a command wrote to a folder, compressed or not; refuse others."""
    files = (out / RESULT, out / f"{RESULT}.gz")
    found = next((file for file in files if file.is_file()), None)
    data = read_record(found) if found is not None else {}
    allowed = f"a folder with the {RESULT} of `cea {command}`"
    require(data.get("command") == command, "out", str(out), allowed)
    return data


def read(name: str, out: Path) -> StudyResult:
    """Read the result of a study from a folder; refuse folders without one."""
    record = read_result(out, name)
    require("cases" in record, "out", str(out), "a result with cases: run the study anew")
    return StudyResult(record, read_arrays(out / ARRAYS))
