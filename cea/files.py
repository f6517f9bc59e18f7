"""Atomic writing of files: an interrupted or failed write leaves no partial file.

Content is written to a hidden file in the same folder, flushed to the disk, and then renamed.
"""

import errno
import gzip
import os
import signal
import threading
from contextlib import suppress
from pathlib import Path

from cea.errors import InputError, WriteError

_LEVEL = 6  # gzip level; the highest takes three times as long and saves a few per cent


def write_whole(content: bytes, file: Path) -> Path:
    """Write a file atomically, creating its folder; compress it if its suffix is ``.gz``."""
    if file.suffix == ".gz":
        content = gzip.compress(content, _LEVEL, mtime=0)
    part = file.with_name(f".{file.name}.{os.getpid()}.part")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with part.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(file)
    except OSError as error:
        raise WriteError(f"{file} cannot be written: {error.strerror or error}") from error
    finally:
        with suppress(OSError):  # the folder or the name may be the reason of the failure
            part.unlink()
    return file


def regular(file: Path) -> Path:
    """Return the file, or raise OSError for devices and pipes, which may have no end."""
    if file.exists() and not file.is_file():
        raise OSError(errno.EINVAL, "not a regular file", str(file))
    return file


def check_writable(file: Path, field: str) -> None:
    """Raise :class:`InputError` if a file cannot be written, before its content is computed."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        regular(file)
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or error
        raise InputError(field, str(file), f"a file to write ({reason})") from None
    if not os.access(file.parent, os.W_OK):
        raise InputError(field, str(file), "a file to write, in a folder that may be written")


def ignore_closed_pipes() -> None:
    """Make a write to a closed pipe raise BrokenPipeError, as Python does by default.

    PETSc handles SIGPIPE itself, and gmsh restores its default, which ends the process: call this
    after either is initialised. Only the main thread can set signals; elsewhere nothing changes.
    """
    if hasattr(signal, "SIGPIPE") and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
