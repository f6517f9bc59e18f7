"""A study: its cases, what is computed for each, and how the results are shown."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

from cea.errors import ConvergenceError, InputError
from comparisons.study.result import StudyResult as StudyResult
from comparisons.study.sections import Section
from comparisons.study.session import Session as Session
from scenes.results.record import as_json
from scenes.spec.reading import Scene

Case = Mapping[str, Any]
"""What sets a case apart: plain values by name, which are columns of every table of it."""
Rows = Mapping[str, Any] | Sequence[Mapping[str, Any]]
"""A row of the table "runs", several of them, or rows by the name of their table."""
CHOOSES: Mapping[str, Any] = {"chooses": True}
"""Metadata of a field of options that only chooses cases: a stored case is taken whatever it is."""


@dataclass(frozen=True)
class Process:
    """How cases are computed in processes of their own.

    Parameters
    ----------
    study
        ``module:name`` of the study, by which the process finds it.
    seconds
        Time for a case, the start of the process not counted.
    at_once
        Processes that share the cases. A case with a label ``ranks`` runs on so many.
    """

    study: str
    seconds: float
    at_once: int = 1


@dataclass(frozen=True)
class Study:
    """Cases, what is computed for each, and how the results are shown.

    Parameters
    ----------
    name
        Name of the command, mark of the record, and folder below ``results``.
    title
        Title of the page.
    options
        Frozen dataclass of what a user may choose: its fields are options of the command, its
        docstring describes them.
    cases
        Cases of given options, in the order in which they are run; all have the same labels. A
        label ``part`` sets parts of a study apart, and is not shown.
    evaluate
        Computes a case: a row, rows, or rows by the name of their table. Collective on several
        ranks. Values are plain: numbers, texts, truths and None where there is no number.
    sections
        Sections of the page.
    scene
        Scene of a case, where it has one, or several by name: part of what a stored case must agree
        in.
    quick
        Options of ``--quick``, which tests run too.
    check
        The fault of a result in one line, which ends the command with code 1; "" where there is
        none.
    process
        Cases are computed in other processes, so that a crash or an overlong case ends itself
        alone; None computes them in this one.
    shipped
        Folder of results that come with the project: cases with equal inputs are taken from there
        at any commit.
    """

    name: str
    title: str
    options: type
    cases: Callable[[Any], Iterable[Case]]
    evaluate: Callable[[Any, Session], Rows | Mapping[str, Rows]]
    sections: Sequence[Section]
    scene: Callable[[Any, Any], Scene | Mapping[str, Any] | None] | None = None
    quick: Mapping[str, Any] = field(default_factory=dict)
    check: Callable[[StudyResult], str] | None = None
    process: Process | None = None
    shipped: Path | None = None


def at_least_one(**fields: int) -> None:
    """Refuse options that are no numbers from 1 on."""
    for name, value in fields.items():
        if value < 1:
            raise InputError(name, value, "1 or more")


def evaluated(
    study: Study, labels: Case, session: Session
) -> tuple[dict[str, Any], dict[str, Any]]:
    """A case with its tables, what its runs took and why it failed, and its arrays."""
    start, tables, failed = perf_counter(), dict[str, Any](), ""
    try:
        session.begin(study.scene(labels, session.options) if study.scene else None)
        tables = _tables(study.evaluate(labels, session))
        as_json(tables)  # refuses what is no plain data, and what is no number
    except (ConvergenceError, InputError) as error:
        tables, failed = {}, str(error) or type(error).__name__
    shapes, numbers = session.shapes.stored()
    case = {
        "labels": dict(labels),
        "tables": tables,
        "runs": session.runs,
        "shapes": shapes,
        "failed": failed,
        "seconds": perf_counter() - start,
    }
    return case, session.arrays | numbers


def _tables(rows: Any) -> dict[str, list[dict[str, Any]]]:
    """Rows by the name of their table, their numbers those of Python, which every reader knows."""
    if not isinstance(rows, Mapping):
        rows = {"runs": list(rows)}
    elif not all(isinstance(each, list) for each in rows.values()):
        rows = {"runs": [rows]}
    return {
        name: [{k: v.item() if hasattr(v, "item") else v for k, v in row.items()} for row in each]
        for name, each in rows.items()
    }
