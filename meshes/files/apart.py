"""Libraries that a broken file may crash, or keep for ever, run as programs of their own."""

import sys
from pathlib import Path
from resource import RLIMIT_AS, RLIMIT_CPU, prlimit
from subprocess import DEVNULL, PIPE, STDOUT, Popen
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cea.errors import InputError

_SECONDS, _SECONDS_A_BYTE = 5, 2e-5
"""Time on a core that reading may take: ten times what it does, and more."""
_BYTES, _BYTES_A_BYTE = 2**32, 300
"""Memory that it may take."""


def arrays_of(program: str, file: Path, *arguments: str) -> dict[str, Any]:
    """Arrays that a program makes of a file.

    Parameters
    ----------
    program
        Module beside this one, run with the file, the file of arrays (.npz) to write, and the
        arguments. It says nothing where all is well.
    file
        The file.
    arguments
        What else the program needs to know.

    Raises
    ------
    InputError
        When the program complains, crashes, or takes too much time or memory.
    """
    size = file.stat().st_size
    seconds, memory = int(_SECONDS + _SECONDS_A_BYTE * size), _BYTES + _BYTES_A_BYTE * size
    with TemporaryDirectory() as folder:
        arrays = Path(folder) / "arrays.npz"
        place = str(Path(__file__).with_name(f"{program}.py"))
        command = [sys.executable, "-P", "-W", "ignore", place, str(file), str(arrays), *arguments]
        with Popen(command, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT) as process:
            prlimit(process.pid, RLIMIT_CPU, (seconds, seconds + 1))
            prlimit(process.pid, RLIMIT_AS, (memory, memory))
            told = process.communicate()[0].decode("utf-8", "replace").strip().splitlines()
        if process.returncode or told or not arrays.is_file():
            reason = f" ({told[-1]})" if told else ""
            allowed = f"a whole {file.suffix} file; it cannot be read{reason}"
            raise InputError("file", str(file), allowed)
        with np.load(arrays, allow_pickle=False) as read:
            return dict(read)
