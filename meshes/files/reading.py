"""Reading of files of meshes, patches and matrices, once as long as they do not change.

Files are checked before they are read. A broken file may crash a library, or keep it running for
ever: it gets a process of its own.
"""

import re
import sys
from collections.abc import Callable, Mapping
from functools import lru_cache
from importlib import import_module
from pathlib import Path, PureWindowsPath
from resource import RLIMIT_AS, RLIMIT_CPU, prlimit
from subprocess import DEVNULL, PIPE, STDOUT, Popen
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cea.errors import InputError, require
from cea.files import regular
from meshes.files.content import FileContent
from meshes.files.part import merged

_MESHES = {
    ".msh": "meshes.files.gmsh.gmsh_content",
    ".inp": "meshes.files.abaqus.abaqus_content",
    ".cdb": "meshes.files.ansys.ansys_content",
    ".bdf": "meshes.files.nastran.nastran_content",
    ".nas": "meshes.files.nastran.nastran_content",
    ".xdmf": "meshes.files.vtk.xdmf_content",
    ".vtu": "meshes.files.vtk.vtu_content",
}
_KEPT = 4
"""Number of files whose content is cached, for the bodies of a scene."""
_WORDLESS = (TypeError, LookupError, AttributeError, AssertionError, SyntaxError, RecursionError)
"""Errors of libraries whose messages do not describe the file."""
_SECONDS, _SECONDS_A_BYTE = 5, 2e-5
"""Limit of processor time (s) of reading: more than ten times what it takes."""
_BYTES, _BYTES_A_BYTE = 2**32, 300
"""Limit of memory (bytes) of reading."""
_LARGEST = 2**33
"""Largest size of a file (bytes)."""
_DEEPEST = 10
"""Largest depth of files that include one another."""


def read_mesh_file(file: Path, merge: float | None = None) -> FileContent:
    """Content of a mesh file, with nodes nearer than ``merge`` merged."""
    content = read_once(file, "a mesh file", _MESHES)
    return content if merge is None else _merged(content, merge)


def read_once(file: Path, what: str, readers: Mapping[str, str], **limits: int) -> Any:
    """Result of the reader of a file, a function chosen by its extension and imported here."""
    reader = readers.get(file.suffix.lower())
    state = checked_state(file, what, **limits)
    if reader is None:
        raise InputError("file", str(file), f"one that ends in {' or '.join(readers)}")
    return _read(reader, *state)


@lru_cache(_KEPT)
def _read(reader: str, file: Path, _changed: int, _size: int) -> Any:
    module, _, function = reader.rpartition(".")
    read = getattr(import_module(module), function)
    try:
        return read(file)
    except InputError as error:
        told = error.value if error.field == "file" else error.field
        name = f"{file.name}: {told}" if told != str(file) else told
        raise InputError("file", name, error.allowed) from None
    except MemoryError:
        raise
    except Exception as error:  # libraries raise any error on a broken file
        told = str(error) if not isinstance(error, _WORDLESS) else ""
        reason = told or "it does not follow its format"
        allowed = f"a whole {file.suffix} file; it cannot be read ({reason})"
        raise InputError("file", str(file), allowed) from None


_merged = lru_cache(_KEPT)(merged)


def checked_state(file: Path, what: str, largest: int = _LARGEST) -> tuple[Path, int, int]:
    """Path, time of last change (ns) and size (bytes) of a file; refuse what is no file."""
    try:
        state = regular(file).stat()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError("file", str(file), f"{what} ({reason})") from None
    require(state.st_size > 0, "file", str(file), "a file that is not empty")
    require(state.st_size <= largest, "file", str(file), f"a file of at most {largest} bytes")
    return file.resolve(), state.st_mtime_ns, state.st_size


def library(file: Path, module: str) -> Any:
    """Import a module of a library that reads the file; refuse it if it is not installed."""
    try:
        return import_module(module)
    except ImportError:
        library = module.partition(".")[0]
        allowed = f"{library} to read it: python -m pip install 'friction-cea[meshes]'"
        raise InputError("file", str(file), allowed) from None


def arrays_of(program: Path, file: Path) -> dict[str, Any]:
    """Arrays that a program writes (.npz) of a file; if it prints anything, it has failed."""
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
    """Text of a file with the text of included files in their places.

    For a match of the pattern, ``included`` returns the text to keep before the file, and its path;
    None if it includes none. Paths are relative to the folder of the first file, as in solvers, or
    else to that of the file that names them; backslashes separate folders.
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
    """Path of a file that another one includes."""
    path = PureWindowsPath(name).as_posix()
    for folder in (chain[0].parent, chain[-1].parent):
        for each in (folder / name, folder / path):
            if each.exists():
                return checked_state(each, "a file that is included")[0]
    allowed = "an included file; its name is case-sensitive"
    raise InputError("file", str(chain[0].parent / path), allowed)
