"""CalculiX: where it is, and what it finds.

Real eigenvalues are read from its binary file (``.eig``), which holds all their digits. Complex
ones stand in its list (``.dat``) alone, with seven.
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
    """Path of CalculiX, refused where it is not installed."""
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


def run(deck: Path) -> Complexes:
    """Run a deck that asks for frequencies on one thread: lambda (1/s) by rising frequency.

    An error where CalculiX is not installed, or ends without results.
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
    """Eigenvalues in the files that a run left beside its deck; none without a list."""
    listed = deck.with_suffix(".dat")
    eigenvalues = _listed(listed.read_text(encoding="utf-8") if listed.is_file() else "")
    kappa = stored_kappa(deck.with_suffix(".eig")) if eigenvalues.size else None
    if kappa is not None:
        eigenvalues = 1j * np.sqrt(kappa.astype(complex))
    return eigenvalues[np.lexsort((eigenvalues.real, eigenvalues.imag))]


def _listed(text: str) -> Complexes:
    """Eigenvalues of the list: of omega = b + i c, printed with both signs of c, lambda = i omega.

    Rows hold the number, and omega^2, omega, frequency, c where matrices are symmetric; omega,
    frequency, c where they are not.
    """
    rows = [_ROW.match(line) for line in text.split(_END_OF_LIST)[0].splitlines()]
    numbers = [[float(word) for word in row.group(1).split()] for row in rows if row]
    return np.array([complex(row[-1], row[-3]) for row in numbers], dtype=complex)


def stored_kappa(file: Path) -> np.ndarray | None:
    """omega^2 (1/s^2) in the binary file of a frequency step; None if it follows a static one."""
    content = file.read_bytes()
    cyclic, hermitian, perturbed, count = struct.unpack_from("=4i", content)
    if (cyclic, hermitian, perturbed) != (0, 1, 0):
        return None
    return np.frombuffer(content, np.float64, count, struct.calcsize("=4i"))
