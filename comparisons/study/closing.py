"""Last sections of every page: warnings, times, what was left out, failed cases, versions."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from comparisons.study.numbers import plain
from comparisons.study.result import StudyResult
from comparisons.study.sections import Section, Table


def closing() -> list[Section]:
    """Last sections of every study: warnings, times, what was left out, failed cases, versions."""
    skipped = "Parts of runs that their scenes do not need."
    return [
        Section("Warnings", tables=[Table("warnings", "Warnings of runs, by kind.", _warnings)]),
        Section("Run times", tables=[Table("times", "Seconds of cases by stage.", _times)]),
        Section("Left out", tables=[Table("skipped", skipped, _left_out)]),
        Section("Failed", tables=[Table("failed", "Cases without a result.", StudyResult.failed)]),
        Section(
            "Parameters",
            tables=[
                Table("parameters", PARAMETERS, lambda result: parameters(result.runs())),
                Table("options", "Options of the study.", lambda r: _named(r.record["inputs"])),
            ],
        ),
        Section("Machine and versions", tables=[Table("machine", "", _machine_of_study)]),
    ]


PARAMETERS = "Fields of the scenes as run, in SI units (angles in degrees); bars separate values."


def _warnings(result: StudyResult) -> pd.DataFrame:
    """Kinds of warnings, with the first message and the number of runs that gave them."""
    given = [
        (warning["kind"], warning["message"], i)
        for i, run in enumerate(result.runs())
        for warning in run["warnings"]
    ]
    frame = pd.DataFrame(given, columns=["warning", "first", "runs"])
    how = {"first": "first", "runs": "nunique"}
    return frame.groupby("warning", sort=False, as_index=False).agg(how)


def _times(result: StudyResult) -> pd.DataFrame:
    rows = []
    for case in result.cases:
        stages = pd.DataFrame([run["stages"] for run in case["runs"]]).sum()
        rows.append(case["labels"] | stages.to_dict() | {"seconds": case["seconds"]})
    return pd.DataFrame(rows)


def _left_out(result: StudyResult) -> pd.DataFrame:
    given = [item for run in result.runs() for item in run["skipped"].items()]
    frame = pd.DataFrame(given, columns=["left_out", "reason"])
    return frame.groupby(["left_out", "reason"], sort=False).size().reset_index(name="runs")


def warned(data: Mapping[str, Any]) -> pd.DataFrame:
    """Hints and warnings of a record."""
    hints = [{"warning": "hint", "message": hint} for hint in data.get("hints", ())]
    rows = [{"warning": w["kind"], "message": w["message"]} for w in data["warnings"]]
    return pd.DataFrame(hints + rows)


def parameters(runs: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Fields of the scenes as run; values that differ between runs are separated by bars."""
    fields = pd.json_normalize([run["scene"] for run in runs])
    values = {
        field: dict.fromkeys(plain(value) for value in fields[field].dropna())
        for field in fields.columns.drop("description", errors="ignore")
    }
    named = [(field, " | ".join(filter(None, texts))) for field, texts in values.items()]
    return pd.DataFrame([row for row in named if row[1]], columns=["field", "value"])


def machine(record: Mapping[str, Any]) -> pd.DataFrame:
    """Machine, versions, and the commit of the program."""
    return _named({**record["machine"], **record["versions"], "commit": record["commit"]})


def _machine_of_study(result: StudyResult) -> pd.DataFrame:
    commits = ", ".join(dict.fromkeys(case["commit"] for case in result.cases))
    return machine({**result.record, "commit": commits or result.record["commit"]})


def _named(values: Mapping[str, Any]) -> pd.DataFrame:
    return pd.DataFrame({"name": list(values), "value": [plain(v) for v in values.values()]})
