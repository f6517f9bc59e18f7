"""A process of its own for cases: a crash or an overlong run ends it, and nothing else."""

import multiprocessing
import os
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any, Protocol

from cea.body import Complexes
from comparisons.accuracy.study import Case

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""What holds numerical libraries to one thread; read as they load, so set before."""


class CaseError(Exception):
    """A case that gave no numbers, and why."""


class Measures(Protocol):
    """Something that measures cases."""

    def measure(self, case: Case, exact: Complexes, repeats: int) -> dict[str, Any]:
        """Measure a case; see :meth:`comparisons.accuracy.measure.Measurer.measure`."""
        ...


def _measurer() -> Measures:
    from comparisons.accuracy.measure import Measurer

    return Measurer()


class Worker:
    """Measures cases in another process, begun anew whenever it has died.

    Parameters
    ----------
    make
        Makes the measurer, in that process; a function of a module.
    """

    def __init__(self, make: Any = _measurer) -> None:
        self._make = make
        self._process: Any = None
        self._connection: Connection | None = None

    def measure(self, case: Case, exact: Complexes, repeats: int, seconds: float) -> dict[str, Any]:
        """Measure a case.

        Parameters
        ----------
        case, exact, repeats
            See :meth:`comparisons.accuracy.measure.Measurer.measure`.
        seconds
            Time for it, the start of the process not counted.

        Raises
        ------
        CaseError
            With the message of the failure, or how the process ended.
        """
        connection = self._begin()
        try:
            connection.send((case, exact, repeats))
            if not connection.poll(seconds):
                self.end()
                raise CaseError(f"took more than {seconds:g} s")
            measured, failure = connection.recv()
        except (EOFError, ConnectionError) as error:
            self._process.join()
            code = self._process.exitcode
            self.end()
            raise CaseError(f"the process that ran it ended with code {code}") from error
        if failure is not None:
            raise CaseError(failure)
        return measured

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


def _serve(connection: Connection, make: Any) -> None:
    """Answer with (numbers, None) or (None, message) until the other end is closed."""
    measurer = make()
    connection.send(None)
    while True:
        try:
            case, exact, repeats = connection.recv()
        except EOFError:
            return
        try:
            connection.send((measurer.measure(case, exact, repeats), None))
        except Exception as error:  # a failed case is data: it must not end the study
            first = (str(error) or repr(error)).splitlines()[0]
            connection.send((None, f"{type(error).__name__}: {first}"))
