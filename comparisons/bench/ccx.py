"""Run CalculiX and read its eigenvalues.

Real eigenvalues are read with all digits from its binary file (``.eig``). Complex eigenvalues are
only in its text file (``.dat``), with seven digits.
"""

import os
import re
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np

from cea.arrays import Complexes
from cea.errors import ConvergenceError, InputError

PROGRAM = "ccx"
_ROW = re.compile(r"^ +\d+((?: +-?\d\.\d+E[+-]\d+){3,4})\s*$")
_VERSION = re.compile(r"Version (\S+)")
_END_OF_LIST = "P A R T I C I P A T I O N"


def program() -> str:
    """Return the path of CalculiX; an InputError if it is not installed."""
    found = shutil.which(PROGRAM)
    if found is None:
        allowed = "CalculiX on the path, as the Debian package calculix-ccx installs it"
        raise InputError("program", PROGRAM, allowed)
    return found


def version() -> str:
    """Return the version of CalculiX, such as ``2.20``."""
    done = subprocess.run([program(), "-v"], capture_output=True, text=True, check=False)
    found = _VERSION.search(done.stdout)
    return found.group(1) if found else "unknown"


def run(deck: Path) -> Complexes:
    """Run a deck with a frequency step on one thread; return lambda (1/s) by frequency.

    InputError if CalculiX is not installed, ConvergenceError if it fails.
    """
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [program(), deck.stem],
        cwd=deck.parent,
        env=environment,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    eigenvalues = results(deck)
    if done.returncode or not eigenvalues.size or "*ERROR" in done.stdout:
        last = " ".join((done.stdout + done.stderr).split()[-30:])
        raise ConvergenceError(f"CalculiX found no eigenvalues of {deck.name}: {last}")
    return eigenvalues


def results(deck: Path) -> Complexes:
    """Return the eigenvalues in the files of a run; empty if there is no ``.dat``."""
    listed = deck.with_suffix(".dat")
    eigenvalues = _listed(listed.read_text(encoding="utf-8") if listed.is_file() else "")
    kappa = stored_kappa(deck.with_suffix(".eig")) if eigenvalues.size else None
    if kappa is not None:
        eigenvalues = 1j * np.sqrt(kappa.astype(complex))
    return eigenvalues[np.lexsort((eigenvalues.real, eigenvalues.imag))]


def _listed(text: str) -> Complexes:
    """Return lambda = i omega of the text file, which prints omega = b + i c.

    A row has the mode number and, for symmetric matrices, omega^2, b, frequency, c; for
    unsymmetric matrices b, frequency, c, printed with both signs of c.
    """
    rows = [_ROW.match(line) for line in text.split(_END_OF_LIST)[0].splitlines()]
    numbers = [[float(word) for word in row.group(1).split()] for row in rows if row]
    return np.array([complex(row[-1], row[-3]) for row in numbers], dtype=complex)


def stored_kappa(file: Path) -> np.ndarray | None:
    """Return omega^2 (1/s^2) of the binary file; None if the step follows a static step."""
    content = file.read_bytes()
    cyclic, hermitian, perturbed, count = struct.unpack_from("=4i", content)
    if (cyclic, hermitian, perturbed) != (0, 1, 0):
        return None
    return np.frombuffer(content, np.float64, count, struct.calcsize("=4i"))
