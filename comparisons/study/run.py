"""Computation of the cases of a study, which resumes interrupted runs."""

import json
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, fields
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from time import perf_counter
from typing import Any

from cea.errors import InputError, require
from cea.petsc import MPI
from comparisons.study.result import StudyResult, read, read_arrays, write_arrays
from comparisons.study.session import Progress, Session
from comparisons.study.study import CHOOSES, Case, Study, evaluated
from comparisons.study.worker import Computed, workers
from scenes.results.record import commit, read_record, record, write_record
from scenes.spec.plain import plain_data

_DIRTY = "-dirty"


def selected(study: Study, options: Any, only: Mapping[str, str]) -> list[Case]:
    """Cases whose labels have the values given as text; refuse values that no case has."""
    cases = list(study.cases(options))
    for name, value in only.items():
        known = any(name in case for case in cases)
        require(known, "only", name, f"one of {', '.join(cases[0])}")
        values = dict.fromkeys(_text(case[name]) for case in cases)
        require(value in values, "only", f"{name}={value}", f"one of {', '.join(values)}")
        cases = [case for case in cases if _text(case[name]) == value]
    return cases


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def run(
    study: Study,
    options: Any,
    out: Path,
    *,
    anew: bool = False,
    only: Mapping[str, str] | None = None,
    progress: Progress | None = None,
) -> StudyResult:
    """Compute the cases that are not stored, or all with ``anew``; rank 0 stores each when done.

    A case stored in the folder ``out`` or beside it is reused if labels, scene, options and the
    commit of the program agree, unless it failed or the checkout has changes. ``only`` has labels
    and values, as text, of the cases to compute; others are included if they are stored. Every
    rank returns the result; :func:`finished` removes the stored cases once it is written.
    """
    comm, begun = MPI.COMM_WORLD, perf_counter()
    alone = not study.process or comm.size == 1
    require(alone, "ranks", comm.size, "1: the study starts processes of its own")
    progress = progress or Progress()
    chosen = [dict(case) for case in selected(study, options, only or {})]
    known = comm.bcast(_known(study, out) if comm.rank == 0 and not anew else {})
    session = Session(options, progress.stage)
    every = [dict(labels) for labels in study.cases(options)]
    computing: AbstractContextManager[Any] = nullcontext(
        lambda labels: evaluated(study, labels, session)
    )
    if study.process:
        computing = workers(study.process, options)
    at_once = study.process.at_once if study.process else 1
    with computing as compute, ThreadPoolExecutor(at_once) as threads:

        def found(labels: dict[str, Any]) -> Computed | None:
            key = key_of(study, options, labels)
            if key in known or labels not in chosen:
                return known.get(key)
            progress.step(", ".join(f"{name} {_text(v)}" for name, v in labels.items()))
            case, own = compute(labels)
            case |= {"key": key, "commit": commit()}
            arrays = {f"{key}/{name}": array for name, array in own.items()}
            if comm.rank == 0:
                write_arrays(arrays, parts(out) / f"{key}.npz")
                write_record(case, parts(out) / f"{key}.json")
            return case, arrays

        entries = threads.map(found, every) if study.process else map(found, every)
        done = [entry for entry in entries if entry is not None]
    arrays = {name: array for _, own in done for name, array in own.items()}
    inputs = json.loads(json.dumps(asdict(options), default=str))
    data, seconds = {"cases": [case for case, _ in done]}, perf_counter() - begun
    return StudyResult(record(study.name, data, inputs=inputs, seconds=seconds), arrays)


def key_of(study: Study, options: Any, labels: Any) -> str:
    """Digest of everything that a case depends on, except the program."""
    scene = plain_data(study.scene(labels, options)) if study.scene else None
    given = asdict(options)
    for each in fields(options):
        if each.metadata == CHOOSES:
            del given[each.name]
    inputs = [study.name, given, labels, scene]
    return sha256(json.dumps(inputs, sort_keys=True, default=str).encode()).hexdigest()[:20]


def parts(out: Path) -> Path:
    """Folder of finished cases of a running study, beside the folder of its result."""
    out = out.absolute()  # the relative path "." has no name
    return out.with_name(f"{out.name}.cases")


def finished(out: Path) -> None:
    """Remove the cases stored while the study ran: its result holds them."""
    rmtree(parts(out), ignore_errors=True)


def _known(study: Study, out: Path) -> dict[str, Computed]:
    """Cases that may be reused: of an interrupted run, of a finished one, and shipped ones."""
    found = _of_result(study, study.shipped) if study.shipped else []
    if not commit().endswith(_DIRTY):
        files = sorted(parts(out).glob("*.json"))
        own = _of_result(study, out)
        own += [(read_record(file), read_arrays(file.with_suffix(".npz"))) for file in files]
        found += [entry for entry in own if entry[0]["commit"] == commit()]
    return {case["key"]: (case, arrays) for case, arrays in found if not case["failed"]}


def _of_result(study: Study, folder: Path) -> list[Computed]:
    """Cases of a finished result; none if there is no result."""
    try:
        result = read(study.name, folder)
    except InputError:
        return []
    arrays: dict[str, dict[str, Any]] = {case["key"]: {} for case in result.cases}
    for name, array in result.arrays.items():
        arrays[name.partition("/")[0]][name] = array
    return [(case, arrays[case["key"]]) for case in result.cases]
