"""A process of its own for runs: a crash or an overlong run ends it, and nothing else."""

import multiprocessing
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from threading import Lock
from typing import Any

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""What holds numerical libraries to one thread; read as they load, so set before."""

_STARTING = Lock()
"""Held while the surroundings are those of a process that begins."""


class WorkerError(Exception):
    """A question that got no answer, and why."""


class Worker:
    """Answers questions in another process, begun anew whenever it has died.

    Parameters
    ----------
    make
        Makes what answers, in that process; a function of a module.
    """

    def __init__(self, make: Callable[[], Callable[..., Any]]) -> None:
        self._make = make
        self._process: Any = None
        self._connection: Connection | None = None

    def ask(self, *question: Any, seconds: float) -> Any:
        """Answer to a question, plain data or what else travels between processes.

        Parameters
        ----------
        question
            Arguments of what answers.
        seconds
            Time for it, the start of the process not counted.

        Raises
        ------
        WorkerError
            With the message of the failure, or how the process ended.
        """
        connection = self._begin()
        try:
            connection.send(question)
            if not connection.poll(seconds):
                self.end()
                raise WorkerError(f"took more than {seconds:g} s")
            answer, failure = connection.recv()
        except (EOFError, ConnectionError) as error:
            self._process.join()
            code = self._process.exitcode
            self.end()
            raise WorkerError(f"the process that ran it ended with code {code}") from error
        if failure is not None:
            raise WorkerError(failure)
        return answer

    def _begin(self) -> Connection:
        if self._connection is None:
            context = multiprocessing.get_context("spawn")
            self._connection, other = context.Pipe()
            self._process = context.Process(target=_serve, args=(other, self._make), daemon=True)
            with _one_thread():
                self._process.start()
            other.close()
            self._connection.recv()  # it is ready
        return self._connection

    def end(self) -> None:
        """End the process, if there is one."""
        if self._connection is not None:
            self._connection.close()
            self._process.kill()
            self._process.join()
        self._connection = self._process = None


@contextmanager
def _one_thread() -> Iterator[None]:
    """Numerical libraries of processes begun meanwhile use one thread."""
    with _STARTING:
        before = {name: os.environ.get(name) for name in _THREADS}
        os.environ.update(dict.fromkeys(_THREADS, "1"))
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value


def _serve(connection: Connection, make: Callable[[], Callable[..., Any]]) -> None:
    """Answer with (answer, None) or (None, message) until the other end is closed."""
    answer = make()
    connection.send(None)
    while True:
        try:
            question = connection.recv()
        except EOFError:
            return
        try:
            connection.send((answer(*question), None))
        except Exception as error:  # a failure is data: it must not end the study
            first = (str(error) or repr(error)).splitlines()[0]
            connection.send((None, f"{type(error).__name__}: {first}"))
