"""Files looked at before they are read, and libraries run as programs of their own.

A broken file may crash a library, or keep it for ever.
"""

import sys
from pathlib import Path
from resource import RLIMIT_AS, RLIMIT_CPU, prlimit
from subprocess import DEVNULL, PIPE, STDOUT, Popen
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cea.errors import InputError, require
from cea.files import regular

_SECONDS, _SECONDS_A_BYTE = 5, 2e-5
"""Time on a core that reading may take: ten times what it does, and more."""
_BYTES, _BYTES_A_BYTE = 2**32, 300
"""Memory that it may take."""


def checked_state(file: Path, what: str, largest: int) -> tuple[Path, int, int]:
    """Path of a file, time of its last change (ns) and size (bytes); refused when it is none."""
    try:
        state = regular(file).stat()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError("file", str(file), f"{what} ({reason})") from None
    require(state.st_size > 0, "file", str(file), "a file that is not empty")
    require(state.st_size <= largest, "file", str(file), f"a file of at most {largest} bytes")
    return file.resolve(), state.st_mtime_ns, state.st_size


def arrays_of(program: Path, file: Path) -> dict[str, Any]:
    """Arrays that a program writes (.npz) of a file; where all is well it prints nothing."""
    size = file.stat().st_size
    seconds, memory = int(_SECONDS + _SECONDS_A_BYTE * size), _BYTES + _BYTES_A_BYTE * size
    with TemporaryDirectory() as folder:
        arrays = Path(folder) / "arrays.npz"
        command = [sys.executable, "-P", "-W", "ignore", str(program), str(file), str(arrays)]
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
