"""Sections of every page: warnings, times, what was left out, what failed, versions."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import pandas as pd

from comparisons.kit.numbers import number, plain
from comparisons.study.columns import Column
from comparisons.study.result import StudyResult
from comparisons.study.sections import Section, Table

_UNITS = {
    "E": "N/m²",
    "rho": "kg/m³",
    "P": "N/m",
    "p": "N/m³",
    "pressure": "N/m²",
    "max_frequency": "Hz",
    "growth_threshold": "1/s",
    "stiffness": "N/m³",
    "start": "°",
    "end": "°",
    "theta": "°",
    "angle": "°",
} | dict.fromkeys(
    (
        *("size", "origin", "inner_radius", "outer_radius", "bottom", "top", "reach"),
        *("translation", "r", "x", "y", "z"),
    ),
    "m",
)


def closing() -> list[Section]:
    """Sections of every study: warnings, times, what was left out, what failed, versions."""
    return [
        Section("Warnings", tables=[Table("warnings", "What runs warn of.", _warnings, _WARNED)]),
        Section("Run times", tables=[Table("times", "Seconds of cases by stage.", _times)]),
        Section(
            "Left out",
            tables=[
                Table(
                    *("skipped", "What runs did without since their scenes do not need it."),
                    _left_out,
                )
            ],
        ),
        Section("Failed", tables=[Table("failed", "Cases without an answer.", StudyResult.failed)]),
        Section(
            "Parameters",
            tables=[
                Table(
                    "parameters",
                    "Fields of the scenes as run; bars part values.",
                    lambda result: parameters(result.runs()),
                ),
                Table("options", "Options of the study.", _options),
            ],
        ),
        Section("Machine and versions", tables=[Table("machine", "", _machine_of_study)]),
    ]


_WARNED = {"runs": Column("runs", show=number)}


def _warnings(result: StudyResult) -> pd.DataFrame:
    """Kinds of warnings with the first of each and the number of runs that gave it."""
    found: dict[str, dict[str, Any]] = {}
    for run in result.runs():
        for warning in run["warnings"]:
            kind, message = warning["kind"], warning["message"]
            row = found.setdefault(kind, {"warning": kind, "first": message, "runs": 0})
            row["runs"] += 1
    return pd.DataFrame(list(found.values()))


def _times(result: StudyResult) -> pd.DataFrame:
    rows = []
    for case in result.cases:
        stages: dict[str, float] = {}
        for run in case["runs"]:
            for name, seconds in run["stages"].items():
                stages[name] = stages.get(name, 0.0) + seconds
        rows.append(case["labels"] | stages | {"seconds": case["seconds"]})
    return pd.DataFrame(rows)


def _left_out(result: StudyResult) -> pd.DataFrame:
    runs = result.runs()
    rows = [
        {"left_out": what, "reason": reason}
        for run in runs
        for what, reason in run["skipped"].items()
    ]
    if not rows:
        return pd.DataFrame()
    counts = pd.DataFrame(rows).groupby(["left_out", "reason"], sort=False).size()
    return counts.reset_index(name="count").assign(runs=len(runs))


def warned(data: Mapping[str, Any]) -> pd.DataFrame:
    """What the result must be read with."""
    hints = [{"warning": "hint", "message": hint} for hint in data.get("hints", ())]
    rows = [{"warning": w["kind"], "message": w["message"]} for w in data["warnings"]]
    return pd.DataFrame(hints + rows)


def parameters(runs: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """Fields of the scenes as run; several values, parted by bars, where runs differ."""
    values: dict[str, dict[str, None]] = {}
    for run in runs:
        for field, value in _flat(run["scene"]):
            if field != "description":
                values.setdefault(field, {})[_with_unit(field, value)] = None
    return pd.DataFrame(
        [(field, " | ".join(texts)) for field, texts in values.items()], columns=["field", "value"]
    )


def _options(result: StudyResult) -> pd.DataFrame:
    return _named(result.record["inputs"])


def machine(record: Mapping[str, Any]) -> pd.DataFrame:
    """Machine, versions, and the commit of the program."""
    return _named({**record["machine"], **record["versions"], "commit": record["commit"]})


def _machine_of_study(result: StudyResult) -> pd.DataFrame:
    commits = ", ".join(dict.fromkeys(case["commit"] for case in result.cases))
    return machine({**result.record, "commit": commits or result.record["commit"]})


def _named(values: Mapping[str, Any]) -> pd.DataFrame:
    return pd.DataFrame({"name": list(values), "value": [plain(v) for v in values.values()]})


def _flat(value: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Fields that are set, by their path."""
    dot = f"{place}." if place else ""
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield from _flat(part, f"{dot}{name}")
    elif isinstance(value, list | tuple) and any(isinstance(part, Mapping) for part in value):
        for i, part in enumerate(value):
            yield from _flat(part, f"{dot}{i}")
    elif value is not None and value != "" and value != () and value != []:
        yield place, value


def _with_unit(field: str, value: Any) -> str:
    unit = _UNITS.get(field.rpartition(".")[2], "")
    space = "" if unit in ("", "°") else " "
    return value if isinstance(value, str) else f"{plain(value)}{space}{unit}"
