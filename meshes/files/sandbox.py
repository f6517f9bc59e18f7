"""Files looked at before they are read, files that include others, libraries run as programs.

A broken file may crash a library, or keep it for ever: it runs as a program of its own.
"""

import re
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path, PureWindowsPath
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
_LARGEST = 2**33
"""Bytes of a file."""
_DEEPEST = 10
"""Files that include one another."""


def checked_state(file: Path, what: str, largest: int = _LARGEST) -> tuple[Path, int, int]:
    """Path of a file, time of its last change (ns) and size (bytes); refused when it is none."""
    try:
        state = regular(file).stat()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError("file", str(file), f"{what} ({reason})") from None
    require(state.st_size > 0, "file", str(file), "a file that is not empty")
    require(state.st_size <= largest, "file", str(file), f"a file of at most {largest} bytes")
    return file.resolve(), state.st_mtime_ns, state.st_size


def library(file: Path, module: str) -> Any:
    """A module of a library that reads the file, where it is installed."""
    try:
        return import_module(module)
    except ImportError:
        library = module.partition(".")[0]
        allowed = f"{library} to read it: python -m pip install 'friction-cea[meshes]'"
        raise InputError("file", str(file), allowed) from None


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


def text_with_included(
    file: Path,
    pattern: re.Pattern[str],
    included: Callable[[re.Match[str]], tuple[str, str] | None],
    clean: Callable[[str], str] = str,
    chain: tuple[Path, ...] = (),
) -> str:
    """Text of a file with those that it includes in their places.

    Of a match of the pattern, ``included`` gives the text that stays before the file and its path;
    None where it includes none. Paths are counted from the folder of the first file, as solvers
    do, then from that of the file that names them; backslashes separate folders.
    """
    allowed = f"files that do not include each other, at most {_DEEPEST} deep"
    require(file not in chain and len(chain) < _DEEPEST, "file", str(file), allowed)
    chain = (*chain, file)

    def spliced(match: re.Match[str]) -> str:
        if (found := included(match)) is None:
            return match[0]
        other = _named(found[1], chain)
        return f"{found[0]}{text_with_included(other, pattern, included, clean, chain)}\n"

    text = file.read_text("utf-8-sig", "replace")
    return pattern.sub(spliced, clean(text))


def _named(name: str, chain: tuple[Path, ...]) -> Path:
    """A file that another one names."""
    path = PureWindowsPath(name).as_posix()
    for folder in (chain[0].parent, chain[-1].parent):
        for each in (folder / name, folder / path):
            if each.exists():
                return checked_state(each, "a file that is included")[0]
    allowed = "a file that is included, in capitals and small letters as it is named"
    raise InputError("file", str(chain[0].parent / path), allowed)
