"""Processes of their own that answer a question in a file, on any number of ranks."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from scenes.results.record import read_record, write_record

_ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    # Ranks that wait give way: others may share their cores.
    "MPIR_CVAR_POLLS_BEFORE_YIELD": "1",
}
_LAST_WORDS = 40


def asked(
    module: str, question: Mapping[str, Any], folder: Path, *, ranks: int, seconds: float
) -> dict[str, Any]:
    """Answer of a module that is run as a program, one thread a rank.

    Parameters
    ----------
    module
        The module; its argument is a file that holds the question, and then the answer.
    question
        Plain data.
    folder
        Where the file is.
    ranks
        Number of ranks.
    seconds
        Time for it.

    Raises
    ------
    ConvergenceError
        When it fails or takes longer, with what it said last.
    """
    file = write_record(question, folder / "question.json")
    command = [*_launcher(ranks), sys.executable, "-m", module, str(file)]
    try:
        done = subprocess.run(
            command,
            env=os.environ | _ENVIRONMENT,
            capture_output=True,
            text=True,
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise ConvergenceError(f"took more than {seconds:g} s") from None
    if done.returncode != 0:
        said = " ".join((done.stdout + done.stderr).split()[-_LAST_WORDS:])
        raise ConvergenceError(f"ended with code {done.returncode}: {said}")
    return read_record(file)


def answer_file(answer: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    """Put an answer in the place of the question, in the file that this program is given."""
    file = Path(sys.argv[1])
    found = answer(read_record(file))
    if MPI.COMM_WORLD.rank == 0:
        write_record(found, file)


def _launcher(ranks: int) -> list[str]:
    """What starts a program on so many ranks."""
    if ranks == 1:
        return []
    beside = Path(sys.executable).with_name("mpiexec")
    found = str(beside) if beside.is_file() else shutil.which("mpiexec")
    if found is None:
        raise InputError("ranks", ranks, "1 where there is no mpiexec")
    return [found, "-n", str(ranks)]
