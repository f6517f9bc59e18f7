"""Every run of the catalogue, each in a process that a crash ends alone, and what came out."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from queue import SimpleQueue
from time import perf_counter
from typing import Any

from cea.errors import InputError
from cea.petsc import MPI
from comparisons.kit.worker import Worker, WorkerError
from comparisons.stability.catalogue import catalogue, numbers_of, runs_of
from comparisons.stability.measure import answerer, failed
from comparisons.stability.parts.case import Run
from scenes.stored import record

Data = dict[str, Any]

COMMAND = "stability"
"""Command that a result is marked with."""

_AT_ONCE = 2
"""Processes that share the cases, where there are so many cores."""


@dataclass(frozen=True)
class StabilityStudy:
    """What is run.

    Parameters
    ----------
    cases
        Names of cases; empty takes all.
    quick
        Whether a few runs of each row are taken rather than all.
    seconds
        Time for a run with its reference: one that takes longer has failed.
    """

    cases: tuple[str, ...] = ()
    quick: bool = False
    seconds: float = 60.0


def run_stability(
    study: StabilityStudy,
    progress: Callable[[str], None] = lambda _: None,
    make: Callable[[], Callable[[str, int], Data]] = answerer,
) -> Data:
    """Run the catalogue.

    Parameters
    ----------
    study
        What is run.
    progress
        Called with the title of each case as it begins.
    make
        Makes what runs one run, in a process of its own.

    Returns
    -------
    dict
        Record: ``cases``, title and subject by name; ``runs``, what each was and what
        :func:`comparisons.stability.measure.judge` found; ``failed``, how many gave another
        verdict than expected.

    Raises
    ------
    InputError
        For an unknown case, or on more ranks than one.
    """
    if MPI.COMM_WORLD.size > 1:
        raise InputError("ranks", MPI.COMM_WORLD.size, "1: runs have a process each")
    begun = perf_counter()
    names = list(dict.fromkeys(study.cases)) or list(catalogue())
    chosen = {name: numbers_of(name, quick=study.quick) for name in names}

    idle: SimpleQueue[Worker] = SimpleQueue()
    workers = [Worker(make) for _ in range(min(_AT_ONCE, os.cpu_count() or 1))]
    for worker in workers:
        idle.put(worker)

    def run(name: str) -> list[Data]:
        progress(catalogue()[name].title)
        worker = idle.get()
        try:
            return [_run(worker, name, number, study.seconds) for number in chosen[name]]
        finally:
            idle.put(worker)

    try:
        with ThreadPoolExecutor(len(workers)) as threads:
            found = [each for runs in threads.map(run, names) for each in runs]
    finally:
        for worker in workers:
            worker.end()
    data = {
        "cases": {
            name: {"title": catalogue()[name].title, "subject": catalogue()[name].subject}
            for name in names
        },
        "runs": found,
        "failed": sum(not each["met"] for each in found),
    }
    inputs = {"cases": names, "quick": study.quick, "seconds": study.seconds}
    return record(COMMAND, data, inputs=inputs, seconds=perf_counter() - begun)


def _run(worker: Worker, name: str, number: int, seconds: float) -> Data:
    described = _described(name, runs_of(name)[number])
    try:
        return described | worker.ask(name, number, seconds=seconds)
    except WorkerError as error:
        return described | failed(str(error))


def _described(name: str, run: Run) -> Data:
    return {
        "case": name,
        "row": run.row,
        "backend": run.way.backend,
        "formulation": run.way.name,
        "reference": run.reference.name if run.reference is not None else None,
        "expected": list(run.expected),
        "easy": run.easy,
        "tolerance": run.tolerance if run.reference is not None else None,
    }
