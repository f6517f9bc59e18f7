"""CalculiX: where it is, what a run of it takes, and what it found.

Real eigenvalues are read from its binary file (``.eig``), which holds all their digits. Complex
ones stand in its list (``.dat``) alone, with seven.
"""

import os
import re
import shutil
import struct
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, sleep

import numpy as np

from cea.arrays import Complexes
from cea.errors import ConvergenceError, InputError

PROGRAM = "ccx"
_INTERVAL = 0.005
"""Seconds between looks at the memory of a process."""
_LARGEST = re.compile(r"VmHWM:\s+(\d+) kB")
_ROW = re.compile(r"^ +\d+((?: +-?\d\.\d+E[+-]\d+){3,4})\s*$")
_AREA = re.compile(r"area, *normal force.*?\n\s*\n\s*(\S+)", re.DOTALL)
_TIME = re.compile(r"Total CalculiX Time: *(\S+)")
_VERSION = re.compile(r"Version (\S+)")
_END_OF_LIST = "P A R T I C I P A T I O N"


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


@dataclass(frozen=True)
class Found:
    """What CalculiX found.

    Parameters
    ----------
    eigenvalues
        lambda (1/s) by rising frequency, each pair with both growth rates, shape (n,).
    measured
        What the process took.
    seconds
        The time it says itself (s).
    area
        Area over which it integrated the contact (m^2); None without one.
    """

    eigenvalues: Complexes
    measured: Measured
    seconds: float
    area: float | None


def program() -> str:
    """Path of CalculiX.

    Raises
    ------
    InputError
        When it is not installed.
    """
    found = shutil.which(PROGRAM)
    if found is None:
        allowed = "CalculiX on the path, as the Debian package calculix-ccx installs it"
        raise InputError("program", PROGRAM, allowed)
    return found


def version() -> str:
    """Its version, as ``2.20``."""
    done = subprocess.run([program(), "-v"], capture_output=True, text=True, check=False)
    found = _VERSION.search(done.stdout)
    return found.group(1) if found else "unknown"


def run(deck: Path) -> Found:
    """Run a deck that asks for frequencies; results are left beside it.

    Raises
    ------
    InputError, ConvergenceError
        When CalculiX is not installed, or ends without results.
    """
    measured = run_measured([program(), deck.stem], deck.parent, f"{deck.stem}.log")
    listed = deck.with_suffix(".dat").read_text(encoding="utf-8")
    eigenvalues = _listed(listed)
    if eigenvalues.size == 0 or "*ERROR" in measured.output:
        raise ConvergenceError(f"CalculiX found no eigenvalues of {deck.name}")
    kappa = stored_kappa(deck.with_suffix(".eig"))
    if kappa is not None:
        eigenvalues = 1j * np.sqrt(kappa.astype(complex))
    area, time = _AREA.search(listed), _TIME.search(measured.output)
    return Found(
        eigenvalues[np.lexsort((eigenvalues.real, eigenvalues.imag))],
        measured,
        float(time.group(1)) if time else measured.clock,
        float(area.group(1)) if area else None,
    )


def _listed(text: str) -> Complexes:
    """Eigenvalues of the list: of omega = b + i c, printed with both signs of c, lambda = i omega.

    Rows hold the number, and omega^2, omega, frequency, c where matrices are symmetric; omega,
    frequency, c where they are not.
    """
    rows = [_ROW.match(line) for line in text.split(_END_OF_LIST)[0].splitlines()]
    numbers = [[float(word) for word in row.group(1).split()] for row in rows if row]
    return np.array([complex(row[-1], row[-3]) for row in numbers], dtype=complex)


def stored_kappa(file: Path) -> np.ndarray | None:
    """omega^2 (1/s^2) of the modes in the binary file of a frequency step.

    None where the step follows a static one: the file then holds no imaginary parts.
    """
    content = file.read_bytes()
    cyclic, hermitian, perturbed, count = struct.unpack_from("=4i", content)
    if (cyclic, hermitian, perturbed) != (0, 1, 0):
        return None
    return np.frombuffer(content, np.float64, count, struct.calcsize("=4i"))


def run_measured(command: Sequence[str], folder: Path, log: str) -> Measured:
    """Run a program on one thread in a folder, where a log takes what it prints.

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
