"""The study of stability: its catalogue of cases, run in separate processes, and verdicts."""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from inspect import getdoc, getmembers, isfunction
from typing import Annotated, Any, get_args

import pandas as pd

from cea.errors import require
from comparisons.stability import (
    cases_bodies,
    cases_contact,
    cases_friction,
    cases_matrices,
    cases_motion,
)
from comparisons.stability.case import Run, Runs, Verdict
from comparisons.stability.verdicts import judged
from comparisons.stability.ways import QUICK
from comparisons.study.numbers import number
from comparisons.study.result import StudyResult
from comparisons.study.sections import Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case, Process, Study

VERDICTS: tuple[str, ...] = get_args(Verdict)  # every verdict, the best first
_MODULES = (cases_bodies, cases_contact, cases_friction, cases_matrices, cases_motion)


@cache
def catalogue() -> dict[str, Callable[[], Runs]]:
    """Every case by its name: the public functions of the modules of cases."""
    found = {
        name: function
        for module in _MODULES
        for name, function in getmembers(module, isfunction)
        if function.__module__ == module.__name__ and not name.startswith("_")
    }
    return dict(sorted(found.items()))


def title_of(name: str) -> str:
    """Title of a case: its docstring."""
    return (getdoc(catalogue()[name]) or "").rstrip(".")


@cache
def runs_of(name: str) -> tuple[Run, ...]:
    """Runs of a case; unknown names are refused."""
    require(name in catalogue(), "case", name, f"one of {', '.join(catalogue())}")
    return tuple(catalogue()[name]())


def numbers_of(name: str, *, quick: bool) -> list[int]:
    """Numbers of the runs of a case, from 0; a quick study takes a few of each row.

    These are the ways of :data:`QUICK`, on alternating backends, or else the first run.
    """
    runs = runs_of(name)
    if not quick:
        return list(range(len(runs)))
    numbers = []
    for r, row in enumerate(dict.fromkeys(run.row for run in runs)):
        own = [i for i, run in enumerate(runs) if run.row == row]
        turn = {name: ("fe", "iga")[(r + k) % 2] for k, name in enumerate(QUICK)}
        picked = [i for i in own if turn.get(runs[i].way.name) == runs[i].way.backend]
        numbers += picked or own[:1]
    return numbers


@dataclass(frozen=True)
class Options:
    """Options of the study."""

    cases: Annotated[tuple[str, ...], "Names of cases; all by default."] = ()
    every: Annotated[bool, "Take all runs of each row, or only a few."] = True


def cases(options: Options) -> Iterator[Case]:
    """Yield a case of the study for each run; refuse names that are not in the catalogue."""
    for name in dict.fromkeys(options.cases or catalogue()):
        for i in numbers_of(name, quick=not options.every):
            run = runs_of(name)[i]
            way = {"backend": run.way.backend, "formulation": run.way.name}
            yield {"case": name, "row": run.row, **way, "run": i}


def evaluate(case: Case, session: Session) -> dict[str, Any]:
    """Verdict on a run, and the numbers on which it is based."""
    run = runs_of(case["case"])[case["run"]]
    return {
        "title": title_of(case["case"]),
        **judged(run),
        "expected": ", ".join(run.expected),
        "reference": run.reference.name if run.reference is not None else None,
        "tolerance": run.tolerance if run.reference is not None else None,
    }


def runs(result: StudyResult) -> pd.DataFrame:
    """Every run; one whose process died or timed out is WRONG."""
    frame, failed = result.frame(), result.failed()
    if failed.empty:
        return frame
    failed = failed.assign(title=failed["case"].map(title_of), verdict="WRONG", met=False)
    return pd.concat([frame, failed], ignore_index=True)


def not_met(result: StudyResult) -> pd.DataFrame:
    """Runs with a verdict or warnings that the catalogue does not allow."""
    frame = runs(result)
    return frame[~frame["met"].astype(bool)]


def by_case(result: StudyResult) -> pd.DataFrame:
    """Number of runs by verdict for each case, and its worst error, residual and time."""
    frame = runs(result)
    gave = {verdict: frame["verdict"] == verdict for verdict in VERDICTS}
    accurate = frame["error"].where(gave["accurate"])
    frame = frame.assign(**gave, runs=1, not_met=~frame["met"].astype(bool), error=accurate)
    how = dict.fromkeys(["runs", *VERDICTS, "not_met"], "sum")
    how |= dict.fromkeys(["error", "residual", "condition", "seconds"], "max")
    return frame.groupby(["title", "case"], sort=False, as_index=False).agg(how)


def headline(result: StudyResult) -> str:
    """Number of runs by verdict."""
    frame = runs(result)
    told = ", ".join(f"{number(int((frame['verdict'] == kind).sum()))} {kind}" for kind in VERDICTS)
    runs_of_cases = f"{number(len(frame))} runs of {frame['case'].nunique()} cases"
    return f"{runs_of_cases}: {told}; {number(len(not_met(result)))} not as expected."


def fault(result: StudyResult) -> str:
    """Error message that names the cases with unexpected runs, or ""."""
    names = list(dict.fromkeys(not_met(result)["case"]))
    return f"runs with unexpected verdicts or warnings: {', '.join(names)}" if names else ""


STUDY = Study(
    name="stability",
    title="Stiff and extreme scenes against references",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    quick={"every": False},
    check=fault,
    process=Process("comparisons.stability.study:STUDY", 60.0, at_once=min(2, os.cpu_count() or 1)),
    sections=[
        Section(
            "Verdicts",
            "A run is accurate, warned of, refused, or WRONG: a wrong answer without a warning. "
            "The catalogue states the allowed verdicts in advance.",
            headline,
            [
                Table("cases", "Verdicts on the runs of each case.", by_case),
                Table("not_met", "Runs not as expected.", not_met, printed=True),
            ],
        ),
        Section("Every run", tables=[Table("runs", "Every run.", runs)]),
    ],
)
