"""One voice for many ranks: rank 0 speaks, and a fault on any rank ends them all."""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from time import monotonic, sleep
from traceback import format_exception
from typing import Any

from cea.errors import ConvergenceError, InputError, WriteError
from comparisons.cli.options import MissingExtraError

_EXPECTED = (InputError, ConvergenceError, WriteError, MissingExtraError)
"""Faults told in a line each, as those of scenes are; any other is told with its traceback."""

_OUTPUT = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EPIPE)
"""Faults of what output goes to, a full disk or a program that has ended."""

_PATIENCE = 5.0
"""Seconds that a rank with a fault gives the others to meet the same one."""

_LAUNCHERS = ("PMI_", "PMIX_", "PMI2_", "OMPI_", "MPI_LOCAL", "MV2_", "SLURM_", "PALS_", "FLUX_")
"""Beginnings of the environment variables by which launchers tell a process its rank."""


def launched_together() -> Any:
    """The communicator of all ranks where a launcher began this process, else None.

    MPI takes longer to begin than many a command takes: a process alone leaves it until it is used.
    """
    if not any(name.startswith(_LAUNCHERS) for name in os.environ):
        return None
    from cea.petsc import MPI

    return MPI.COMM_WORLD


@contextmanager
def one_voice(comm: Any) -> Iterator[None]:
    """Let rank 0 print; a fault inside ends the program on every rank, told once.

    A fault that all ranks meet is told by rank 0. Where others run on, they may wait for this rank
    for ever: then it tells its fault itself and aborts them.
    """
    if comm is None:
        try:
            yield
        except Exception as error:
            _tell(_told(error))
            sys.exit(1)
        return
    meeting = comm.Dup()  # a meeting of ranks must not match messages of their work
    try:
        with ExitStack() as silence:
            if comm.rank > 0:
                nothing = silence.enter_context(open(os.devnull, "w"))
                silence.enter_context(redirect_stdout(nothing))
                silence.enter_context(redirect_stderr(nothing))
            yield
    except Exception as error:
        _end(meeting, _told(error))


def _told(error: Exception) -> str:
    if isinstance(error, _EXPECTED) or _is_of_a_scene(error):
        return "".join(f"error: {line}\n" for line in str(error).splitlines())
    if isinstance(error, OSError) and error.errno in _OUTPUT:
        return f"error: output cannot be written: {error.strerror}\n"
    if isinstance(error, MemoryError):
        return f"error: not enough memory{f': {error}' if str(error) else ''}\n"
    return "".join(format_exception(error))


def _is_of_a_scene(error: Exception) -> bool:
    """Whether a scene was refused; only what has read scenes can refuse one."""
    refusals = sys.modules.get("scenes.spec.problems")
    return refusals is not None and isinstance(error, refusals.SceneError)


def _tell(fault: str) -> None:
    try:
        sys.stdout.flush()
    except OSError:  # what is left must not be tried again as the program ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.stderr.write(fault)
    sys.stderr.flush()


def _end(comm: Any, fault: str) -> None:
    everyone = _all_arrive(comm)
    if comm.rank == 0 or not everyone:
        _tell(fault)
    if not everyone:
        comm.Abort(1)
    sys.exit(1)


def _all_arrive(comm: Any) -> bool:
    """Whether all ranks come here before patience runs out."""
    arrived = comm.Ibarrier()
    deadline = monotonic() + _PATIENCE
    while not arrived.Test():
        if monotonic() > deadline:
            return False
        sleep(0.01)
    return True
