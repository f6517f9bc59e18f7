"""A study: its cases, what is computed for each, and how the results are shown."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

from cea.errors import ConvergenceError, InputError, require
from comparisons.study.result import StudyResult as StudyResult
from comparisons.study.sections import Section
from comparisons.study.session import Session as Session
from scenes.results.record import as_json
from scenes.spec.reading import Scene

Case = Mapping[str, Any]
"""Labels of a case: plain values by name, which are columns of each of its tables."""
Rows = Mapping[str, Any] | Sequence[Mapping[str, Any]]
"""A row of the table "runs", several of them, or rows by the name of their table."""
CHOOSES: Mapping[str, Any] = {"chooses": True}
"""Metadata of an option that only selects cases: stored cases are reused whatever its value."""


@dataclass(frozen=True)
class Process:
    """Computation of cases in separate processes: a crash or a timeout ends only its own case.

    A case with a label ``ranks`` runs on that many ranks.
    """

    study: str  # ``module:name`` of the study, which the process imports
    seconds: float  # time limit of a case, without the start of the process
    at_once: int = 1  # number of processes that share the cases


@dataclass(frozen=True)
class Study:
    """Cases, what is computed for each, and how the results are shown.

    All cases have the same labels. ``evaluate`` is collective; its values are numbers, texts,
    booleans, and None if missing.
    """

    name: str  # of the command, of its records, and of the folder below ``results``
    title: str
    # frozen dataclass: fields that are annotated with their help are options of the command
    options: type
    cases: Callable[[Any], Iterable[Case]]  # of given options, in the order of running
    evaluate: Callable[[Any, Session], Rows | Mapping[str, Rows]]
    sections: Sequence[Section]
    # scene of a case, or several by name: a stored case is reused only if they are equal
    scene: Callable[[Any, Any], Scene | Mapping[str, Any] | None] | None = None
    quick: Mapping[str, Any] = field(default_factory=dict)  # options of ``--quick`` and of tests
    check: Callable[[StudyResult], str] | None = None  # error that ends the command, or ""
    process: Process | None = None  # None: cases are computed in this process
    shipped: Path | None = None  # folder of results whose cases are reused at any commit


def at_least_one(**fields: int) -> None:
    """Refuse options below 1."""
    for name, value in fields.items():
        require(value >= 1, name, value, "1 or more")


def evaluated(
    study: Study, labels: Case, session: Session
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Evaluate a case: its tables, records of its runs, reason of a failure; and its arrays."""
    start, tables, failed = perf_counter(), dict[str, Any](), ""
    try:
        session.begin(study.scene(labels, session.options) if study.scene else None)
        tables = _tables(study.evaluate(labels, session))
        as_json(tables)  # refuses values that are not plain data, and NaN
    except (ConvergenceError, InputError) as error:
        tables, failed = {}, str(error) or type(error).__name__
    case = {
        "labels": dict(labels),
        "tables": tables,
        "runs": session.runs,
        "shapes": session.shapes.plain(),
        "failed": failed,
        "seconds": perf_counter() - start,
    }
    return case, session.arrays


def _tables(rows: Any) -> dict[str, list[dict[str, Any]]]:
    """Rows by the name of their table, with numpy scalars converted to Python numbers."""
    if not isinstance(rows, Mapping):
        rows = {"runs": list(rows)}
    elif not all(isinstance(each, list) for each in rows.values()):
        rows = {"runs": [rows]}
    return {
        name: [{k: v.item() if hasattr(v, "item") else v for k, v in row.items()} for row in each]
        for name, each in rows.items()
    }
