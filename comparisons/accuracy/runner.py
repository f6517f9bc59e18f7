"""Running a study: cheap cases first, nothing ends it, and what gave no numbers is told."""

import os
from collections.abc import Callable, Iterable
from dataclasses import asdict
from time import perf_counter
from typing import Any, Protocol

from cea.errors import InputError
from cea.petsc import MPI
from comparisons.accuracy.exact_lists import exact
from comparisons.accuracy.problems import problem
from comparisons.accuracy.study import Case, Study, cases
from comparisons.accuracy.worker import CaseWorker
from comparisons.kit.worker import WorkerError
from scenes.results.record import record

Data = dict[str, Any]

COMMAND = "accuracy"
"""Command that a record is marked with."""

_GROWTH = 1.0
"""Exponent with which run time is expected to grow with the elements: what all of it does not
exceed on small meshes, where much of it is overhead."""
_DIGITS = 4
"""Significant digits of run times, memory and errors."""


class Measurer(Protocol):
    """What measures cases: :class:`comparisons.accuracy.worker.CaseWorker`."""

    def measure(self, case: Case, exact: Any, repeats: int, seconds: float) -> Data:
        """Measure one case within so many seconds, or raise WorkerError."""
        ...


def run_study(
    study: Study,
    names: Iterable[str],
    progress: Callable[[str], None] = lambda _: None,
    worker: Measurer | None = None,
) -> Data:
    """Run every case of a study that its time allows.

    Parameters
    ----------
    study
        How far it goes.
    names
        Names of the problems.
    progress
        Called with each case, in words, as it begins.
    worker
        What measures cases; by default a process of its own.

    Returns
    -------
    dict
        Record: ``problems`` with the exact eigenvalues of what was run, ``runs``, ``omissions``
        with a reason each. Its inputs are the study and the names of the problems.

    Raises
    ------
    InputError
        For an unknown problem, or on more ranks than one.
    """
    if MPI.COMM_WORLD.size > 1:
        raise InputError("ranks", MPI.COMM_WORLD.size, "1: run times are those of one thread")
    start = perf_counter()
    problems = [problem(name) for name in names]
    own = CaseWorker() if worker is None else None
    every = [_Problem(study, chosen.name, own or worker, progress) for chosen in problems]
    end = start + 60 * study.minutes
    try:
        for i, (chosen, part) in enumerate(zip(problems, every, strict=True)):
            now = perf_counter()
            part.run(cases(study, chosen), now + (end - now) / (len(problems) - i))
        for part in every:  # what others left of their time
            part.run(part.postponed, end)
    finally:
        if own is not None:
            own.end()
    runs = [run for part in every for run in part.runs]
    data = {
        "problems": {p.name: _described(p.name, runs) for p in problems},
        "runs": runs,
        "omissions": [omission for part in every for omission in part.told_omissions()],
    }
    inputs = {"study": asdict(study), "problems": [chosen.name for chosen in problems]}
    found = record(COMMAND, data, inputs=inputs, seconds=perf_counter() - start)
    found["machine"]["load"] = os.getloadavg()[0]
    return found


class _Problem:
    """The cases of one problem."""

    def __init__(
        self, study: Study, name: str, worker: Any, progress: Callable[[str], None]
    ) -> None:
        self._study, self._name = study, name
        self._worker, self._progress = worker, progress
        self.runs: list[Data] = []
        self.omissions: list[Data] = []
        self.postponed: list[Case] = []

    def run(self, chosen: list[Case], deadline: float) -> None:
        """Run cases in their order; each ends among the runs, the omissions or those postponed."""
        self.postponed = []
        for case in chosen:
            if perf_counter() > deadline:
                self.postponed.append(case)
                continue
            reason = self._reason_to_leave_out(case)
            if reason is None:
                self._progress(case.label)
                try:
                    self.runs.append(case.described() | self._measure(case))
                    continue
                except WorkerError as failure:
                    reason = str(failure)
            self.omissions.append(case.described() | {"reason": reason})

    def told_omissions(self) -> list[Data]:
        """Cases that gave no numbers, those for which there was no time among them."""
        reason = {"reason": "the time of the study was up"}
        return self.omissions + [case.described() | reason for case in self.postponed]

    def _measure(self, case: Case) -> Data:
        values = exact(self._name, case.stiffness)
        measured = self._worker.measure(
            case, values, self._study.repeats, seconds=self._study.case_seconds
        )
        return _rounded(measured)

    def _reason_to_leave_out(self, case: Case) -> str | None:
        failed = [o for o in self.omissions if _line(o) == _line(case.described())]
        if any(o["refinement"] < case.refinement for o in failed):
            return f"a coarser mesh was left out: {failed[0]['reason']}"
        expected = self._expected_seconds(case)
        if expected > self._study.case_seconds:
            return f"more than {self._study.case_seconds:g} s expected for its runs"
        return None

    def _expected_seconds(self, case: Case) -> float:
        """Seconds for all runs of a case, from the finest coarser mesh of its line."""
        line = [run for run in self.runs if _line(run) == _line(case.described())]
        coarser = [run for run in line if run["refinement"] < case.refinement]
        if not coarser:
            return 0.0
        last = max(coarser, key=lambda run: run["refinement"])
        more = (case.refinement / last["refinement"]) ** problem(self._name).dim
        return sum(last["seconds"]) * more**_GROWTH


def _rounded(value: Any) -> Any:
    """Measured data with the digits that measurements have."""
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}")
    if isinstance(value, dict):
        return {key: _rounded(part) for key, part in value.items()}
    return [_rounded(part) for part in value] if isinstance(value, list) else value


def _line(described: Data) -> tuple[Any, ...]:
    """What the cases of a line share."""
    return described["problem"], *described["method"].values(), described["stiffness"]


def _described(name: str, runs: list[Data]) -> Data:
    chosen = problem(name)
    reached = dict.fromkeys(run["stiffness"] for run in runs if run["problem"] == name)
    spectra = [(p, chosen.listed(exact(name, p))) for p in reached]
    return {
        "dim": chosen.dim,
        "band": list(chosen.band),
        "unit": chosen.unit,
        "friction": chosen.friction.strip('"'),
        "highest_order": chosen.highest_order,
        "max_frequency": chosen.max_frequency,
        "exact": [
            {"stiffness": p, "lambda": [[float(v.real), float(v.imag)] for v in values]}
            for p, values in spectra
        ],
    }
