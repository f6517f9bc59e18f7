"""What a study found: a record of its cases, read as data frames and arrays."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from cea.errors import InputError
from comparisons.kit.records import RESULT, read_result
from scenes.results.record import read_record

ARRAYS = "arrays.npz"
"""File of the arrays beside the record."""


@dataclass(frozen=True)
class StudyResult:
    """A study that was just run or read back.

    Parameters
    ----------
    record
        Provenance, ``once``, and ``cases`` with ``labels``, ``key``, ``commit``, ``seconds``,
        ``failed``, ``tables`` of rows, ``shapes`` and ``runs``.
    arrays
        Arrays by key of the case, then name.
    """

    record: Mapping[str, Any]
    arrays: Mapping[str, Mapping[str, np.ndarray]] = field(default_factory=dict)
    _frames: dict[str, pd.DataFrame] = field(default_factory=dict, repr=False)

    @property
    def once(self) -> Mapping[str, Any]:
        """What was computed once for all cases."""
        return self.record["once"]

    @property
    def cases(self) -> list[dict[str, Any]]:
        """Cases in the order of the study."""
        return self.record["cases"]

    def frame(self, table: str = "runs") -> pd.DataFrame:
        """Rows of a table of all cases, the labels of their case before them; a copy."""
        if table not in self._frames:
            self._frames[table] = pd.DataFrame(
                [
                    case["labels"] | row
                    for case in self.cases
                    for row in case["tables"].get(table, ())
                ]
            )
        return self._frames[table].copy()

    def array(self, case: Mapping[str, Any], name: str) -> np.ndarray:
        """Array that the case with these labels kept.

        Raises
        ------
        InputError
            When there is none.
        """
        for found in self.cases:
            if case.items() <= found["labels"].items() and name in self.arrays.get(
                found["key"], {}
            ):
                return self.arrays[found["key"]][name]
        raise InputError("array", name, f"one that the case {dict(case)} kept")

    def failed(self) -> pd.DataFrame:
        """Cases without an answer, and why."""
        return pd.DataFrame(
            [case["labels"] | {"reason": case["failed"]} for case in self.cases if case["failed"]]
        )

    def runs(self) -> list[dict[str, Any]]:
        """What every run of a scene took and left out, with the labels of its case."""
        return [run | {"labels": case["labels"]} for case in self.cases for run in case["runs"]]

    def save(self, out: Path) -> None:
        """Write record and arrays to a folder."""
        from scenes.results.record import write_record

        write_record(self.record, out / RESULT)
        write_arrays({f"{k}/{n}": a for k, own in self.arrays.items() for n, a in own.items()}, out)


def write_arrays(arrays: Mapping[str, np.ndarray], out: Path, name: str = ARRAYS) -> None:
    """Write arrays, if there are some; the same bytes for the same arrays."""
    if arrays:
        out.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(out / name, allow_pickle=False, **arrays)


def read(name: str, out: Path) -> StudyResult:
    """Read what a study wrote to a folder.

    Parameters
    ----------
    name
        Name of the study.
    out
        The folder.

    Raises
    ------
    InputError
        When it holds no result of that study.
    """
    record = read_result(out, name)
    if "cases" not in record:
        raise InputError("out", str(out), "a result with cases: run the study anew")
    return StudyResult(record, _read_arrays(out))


def _read_arrays(out: Path) -> dict[str, dict[str, np.ndarray]]:
    arrays: dict[str, dict[str, np.ndarray]] = {}
    if (out / ARRAYS).is_file():
        with np.load(out / ARRAYS, allow_pickle=False) as stored:
            for whole in stored.files:
                key, _, name = whole.partition("/")
                arrays.setdefault(key, {})[name] = stored[whole]
    return arrays


def read_case(file: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """A case that was stored while its study ran, with its arrays."""
    arrays = {}
    beside = file.with_suffix(".npz")
    if beside.is_file():
        with np.load(beside, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
    return read_record(file), arrays
