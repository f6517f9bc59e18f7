"""Computation of cases in separate processes, on any number of ranks.

``python -m comparisons.study.worker MODULE:STUDY`` reads options as a line of JSON, then a case
from each line, and answers with a line of JSON after a mark, since libraries may print, too.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from importlib import import_module
from pathlib import Path
from queue import Empty, Queue
from threading import Thread, get_ident
from typing import Any

from cea.errors import InputError
from cea.petsc import MPI
from comparisons.study.session import Session
from comparisons.study.study import Process, evaluated

_MARK = "\x1eanswer "
_STARTS = 120.0  # time limit of the start of a process (s)
_ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MPIR_CVAR_POLLS_BEFORE_YIELD": "1",  # waiting ranks yield: others may share their cores
}


Computed = tuple[dict[str, Any], Mapping[str, Any]]  # a case, and its arrays by name


@contextmanager
def workers(process: Process, options: Any) -> Iterator[Callable[[dict[str, Any]], Computed]]:
    """Provide a function that computes a case in a process of the calling thread.

    The processes end with the context. Cases are sent as text, without arrays.
    """
    of_threads: dict[tuple[int, int], Worker] = {}  # by thread and number of ranks

    def evaluate(labels: dict[str, Any]) -> Computed:
        key = get_ident(), labels.get("ranks", 1)
        if key not in of_threads:
            of_threads[key] = Worker(process.study, asdict(options), key[1])
        return of_threads[key].evaluate(labels, process.seconds), {}

    try:
        yield evaluate
    finally:
        for worker in of_threads.values():
            worker.end()


class Worker:
    """Process that computes cases of the study ``module:name``, restarted when it has ended."""

    def __init__(self, study: str, options: dict[str, Any], ranks: int) -> None:
        self._command = [*launcher(ranks), sys.executable, "-m", __name__, study]
        self._options = options
        self._process: subprocess.Popen[str] | None = None

    def evaluate(self, labels: dict[str, Any], seconds: float) -> dict[str, Any]:
        """Compute a case; return a failed one if it exceeds ``seconds`` or ends the process."""
        process = self._process or self._begin()
        if line := self._ask(process, labels, seconds):
            return json.loads(line.removeprefix(_MARK))
        try:
            reason = f"ended with code {process.wait(0.2)}"
        except subprocess.TimeoutExpired:
            reason = f"took more than {seconds:g} s"
        self.end()
        return {"labels": labels, "tables": {}, "runs": [], "failed": reason,
                "shapes": {"scenes": {}, "modes": {}}, "seconds": seconds}  # fmt: skip

    def _begin(self) -> "subprocess.Popen[str]":
        self._process = subprocess.Popen(
            self._command,
            env=os.environ | _ENVIRONMENT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self._lines: Queue[str] = Queue()
        Thread(target=_read, args=(self._process.stdout, self._lines), daemon=True).start()
        self._ask(self._process, self._options, _STARTS)  # answered when it is ready
        return self._process

    def _ask(self, process: Any, question: Any, seconds: float) -> str:
        """Marked line that answers; "" if none comes in time or the process has ended."""
        try:
            process.stdin.write(json.dumps(question) + "\n")
            process.stdin.flush()
            return self._lines.get(timeout=seconds)
        except (BrokenPipeError, Empty):
            return ""

    def end(self) -> None:
        """End the process and its ranks."""
        if self._process is not None and self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        self._process = None


def _read(stream: Any, lines: Queue[str]) -> None:
    for line in stream:
        if line.startswith(_MARK):
            lines.put(line)
    lines.put("")  # the process has ended


def launcher(ranks: int) -> list[str]:
    """Command that starts a program on several ranks; refused if there is no mpiexec."""
    if ranks == 1:
        return []
    beside = Path(sys.executable).with_name("mpiexec")
    found = str(beside) if beside.is_file() else shutil.which("mpiexec")
    if found is None:
        raise InputError("ranks", ranks, "1, since mpiexec was not found")
    return [found, "-n", str(ranks)]


def main(name: str) -> None:
    """Compute a case for each line of the input of rank 0."""
    comm = MPI.COMM_WORLD

    def next_line() -> Any:
        return comm.bcast(sys.stdin.readline() if comm.rank == 0 else None)

    def answer(data: Any) -> None:
        if comm.rank == 0:
            sys.stdout.write(f"\n{_MARK}{json.dumps(data)}\n")
            sys.stdout.flush()

    module, _, attribute = name.partition(":")
    study = getattr(import_module(module), attribute)
    given = json.loads(next_line())
    options = {name: tuple(v) if isinstance(v, list) else v for name, v in given.items()}
    session = Session(study.options(**options))
    answer(None)
    while line := next_line():
        answer(evaluated(study, json.loads(line), session)[0])


if __name__ == "__main__":
    main(sys.argv[1])
