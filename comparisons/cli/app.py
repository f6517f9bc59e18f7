"""The command line ``cea``: its commands, each a function that imports what it uses.

In parallel runs only rank 0 prints, and an error on any rank ends all of them.
"""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from importlib import import_module
from io import TextIOWrapper
from time import monotonic, sleep
from traceback import format_exception
from typing import Annotated, Any

import typer
from typer import Option

import cea
from cea.errors import ConvergenceError, InputError, WriteError
from comparisons.cli.options import PLAIN, LazyGroup

COMMANDS = {
    "run": ("run:run", "Run one scene and write its result.json."),
    "converge": ("sweep:converge", "Refine a scene until its modes meet the target tolerance."),
    "solve": ("run:solve", "Solve (lambda^2 M + lambda C + K) x = 0 for matrices from files."),
    "sweep": ("sweep:sweep", "Follow the modes of a scene along its fields: which grow where."),
    "threshold": ("sweep:threshold", "Find where flutter begins and ends along a field."),
    "study": ("study:app", "Run a study: both backends, formulations, accuracy, damping, ..."),
    "paper": ("study:paper", "Make figures of the paper and check its claims."),
    "bench": ("study:bench", "Compare time and memory with other programs and methods."),
    "scene": ("scene:app", "Check, list and export scenes without running them."),
    "exact": ("exact:app", "Exact eigenvalues of frictional contacts."),
    "doctor": ("app:doctor", "Check whether this installation works, and how to repair it."),
}
"""Module and function of each command below this package, and its help text."""
RENAMED = {
    "accuracy": "study accuracy",
    "brake": "study brake",
    "claims": "paper claims",
    "damping": "study damping",
    "stability": "study stability",
    "compare": "study agreement",
    "export": "scene export",
    "figure": "paper",
    "formulations": "study patch_tests or locking",
    "peers": "bench calculix",
    "race": "solve",
    "reference": "converge disc_pad",
}
"""Old names of commands, and their current names."""


class _Commands(LazyGroup):
    """All commands; ``--help`` has a default, for which typer would otherwise import pydantic."""

    table = COMMANDS

    def get_help_option(self, ctx: Any) -> Any:
        """The option ``--help``, False by default."""
        option = super().get_help_option(ctx)
        if option is not None:
            option.default = False
        return option

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse arguments; refuse empty ones, since an empty path would mean the current folder."""
        for before, given in zip(["", *args], args, strict=False):
            name, equals, value = given.partition("=")
            if not given or (name.startswith("--") and equals and not value):
                option = name or (before if before.startswith("--") else "")
                raise InputError(option[2:] or "argument", "", "something that is not empty")
        return super().parse_args(ctx, args)

    def get_command(self, ctx: Any, name: str) -> Any:
        """A command; an old name is refused with the current one."""
        if name in RENAMED:
            raise InputError("command", name, f"its new name: cea {RENAMED[name]}")
        return super().get_command(ctx, name)

    def make(self, name: str) -> Any:
        """Import a command."""
        module, _, attribute = self.table[name][0].partition(":")
        return getattr(import_module(f"comparisons.cli.{module}"), attribute)


app = typer.Typer(cls=_Commands, no_args_is_help=True, pretty_exceptions_enable=False, **PLAIN)


def _tell_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"friction-cea {cea.__version__}")
        raise typer.Exit


@app.callback()
def _command(
    version: Annotated[
        bool, Option("--version", callback=_tell_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Friction-induced flutter by complex eigenvalue analysis."""


def main() -> None:
    """Run a command; wrong input and failed convergence end in one line, not a traceback."""
    # Threads slow down products of small matrices, by large factors on a busy machine.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # characters that cannot be shown end no run
    with one_voice(launched_together()):
        app(standalone_mode=True)


_EXPECTED = (InputError, ConvergenceError, WriteError)
"""Errors printed in one line each, as those of scenes are; others come with a traceback."""

_OUTPUT = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EPIPE)
"""System errors of writing: a full disk, a file that is too large, a closed pipe."""

_PATIENCE = 5.0  # seconds that a failing rank waits for the others to fail too

_LAUNCHERS = ("PMI_", "PMIX_", "PMI2_", "OMPI_", "MPI_LOCAL", "MV2_", "SLURM_", "PALS_", "FLUX_")
"""Prefixes of environment variables in which MPI launchers pass the rank of a process."""


def launched_together() -> Any:
    """The communicator of all ranks if a launcher started this process, else None.

    Starting MPI takes longer than many commands: a single process starts it when it is used.
    """
    if not any(name.startswith(_LAUNCHERS) for name in os.environ):
        return None
    from cea.petsc import MPI

    return MPI.COMM_WORLD


@contextmanager
def one_voice(comm: Any) -> Iterator[None]:
    """Let only rank 0 print; an error inside ends the program on every rank, and is printed once.

    Rank 0 prints an error that all ranks raise. If others run on, they may wait for the failing
    rank for ever: then it prints its error itself and aborts them.
    """
    meeting = comm and comm.Dup()  # the barrier must not match messages of the computation
    try:
        with ExitStack() as silence:
            if comm and comm.rank > 0:
                nothing = silence.enter_context(open(os.devnull, "w"))
                silence.enter_context(redirect_stdout(nothing))
                silence.enter_context(redirect_stderr(nothing))
            yield
    except Exception as error:
        everyone = meeting is None or _all_arrive(meeting)
        if not everyone or not meeting or meeting.rank == 0:
            _tell(_told(error))
        if not everyone:
            meeting.Abort(1)
        sys.exit(1)


def _told(error: Exception) -> str:
    refusals = sys.modules.get("scenes.spec.problems")  # imported if a scene was read
    if isinstance(error, (*_EXPECTED, *([refusals.SceneError] if refusals else []))):
        return "".join(f"error: {line}\n" for line in str(error).splitlines())
    if isinstance(error, OSError) and error.errno in _OUTPUT:
        return f"error: output cannot be written: {error.strerror}\n"
    if isinstance(error, MemoryError):
        return f"error: not enough memory{f': {error}' if str(error) else ''}\n"
    return "".join(format_exception(error))


def _tell(fault: str) -> None:
    try:
        sys.stdout.flush()
    except OSError:  # the rest of the output must not be written again at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.stderr.write(fault)
    sys.stderr.flush()


def _all_arrive(comm: Any) -> bool:
    arrived = comm.Ibarrier()
    deadline = monotonic() + _PATIENCE
    while not arrived.Test():
        if monotonic() > deadline:
            return False
        sleep(0.01)
    return True


def doctor() -> None:
    """Check whether this installation works, and how to repair it; exit code 1 if it does not."""
    from comparisons.doctor import examine

    faults = 0
    for finding in examine(launched=launched_together() is not None):
        mark = "FAULT" if finding.mend else "well "
        typer.echo(f"{mark}  {finding.name}: {finding.told}")
        if finding.mend is not None:
            faults += 1
            typer.echo(f"       to repair it: {finding.mend}")
    typer.echo("all is well" if not faults else f"faults: {faults}")
    if faults:
        raise typer.Exit(1)
