"""Other processes, run with their seconds and memory measured."""

import os
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, sleep

from cea.errors import ConvergenceError

_INTERVAL = 0.005
"""Seconds between looks at its memory."""
_LARGEST = re.compile(r"VmHWM:\s+(\d+) kB")


@dataclass(frozen=True)
class Measured:
    """What a whole process took.

    Parameters
    ----------
    clock, processor
        Seconds by the clock, and of the processor.
    memory
        Largest memory it held (bytes), but for its last few milliseconds.
    output
        What it printed.
    """

    clock: float
    processor: float
    memory: int
    output: str


def run_measured(command: Sequence[str], folder: Path, log: str) -> Measured:
    """Run a program on one thread in a folder.

    Parameters
    ----------
    command
        The program and its arguments.
    folder
        The folder it is run in.
    log
        Name of the file there that takes what it prints.

    Raises
    ------
    ConvergenceError
        When it ends with another code than 0, with the last it said.
    """
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with (folder / log).open("wb") as stream:
        begun = perf_counter()
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=stream, stderr=subprocess.STDOUT
        )
        memory = ended = status = 0
        while not ended:
            memory = max(memory, _largest_memory(process.pid))
            ended, status, usage = os.wait4(process.pid, os.WNOHANG)
            sleep(0.0 if ended else _INTERVAL)
        clock = perf_counter() - begun
    process.returncode = os.waitstatus_to_exitcode(status)
    output = (folder / log).read_text(encoding="utf-8", errors="replace")
    if process.returncode != 0:
        last = " ".join(output.split()[-30:])
        raise ConvergenceError(f"{command[0]} ended with code {process.returncode}: {last}")
    return Measured(clock, usage.ru_utime + usage.ru_stime, memory, output)


def _largest_memory(process: int) -> int:
    """Largest memory (bytes) that a process has held since it began its program.

    What the system sums up at its end counts the process from which it was made, too.
    """
    try:
        status = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    except OSError:
        return 0
    found = _LARGEST.search(status)
    return int(found.group(1)) * 1024 if found else 0
