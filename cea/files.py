"""Atomic writing of files: an interrupted or failed write leaves no partial file.

Content is written to a hidden file in the same folder, flushed to the disk, and then renamed.
"""

import errno
import gzip
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cea.errors import InputError, WriteError

_LEVEL = 6  # gzip level; the highest takes three times as long and saves a few per cent


def write_whole(content: bytes, file: Path) -> Path:
    """Write a file atomically, creating its folder; compress it if its suffix is ``.gz``."""
    if file.suffix == ".gz":
        content = gzip.compress(content, _LEVEL, mtime=0)
    part = file.with_name(f".{file.name}.{os.getpid()}.part")
    try:
        with _told(file):
            file.parent.mkdir(parents=True, exist_ok=True)
            with part.open("wb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            part.replace(file)
            _sync(file.parent)
    finally:
        with _told(file):
            part.unlink(missing_ok=True)
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


@contextmanager
def _told(place: Path) -> Iterator[None]:
    """Turn an OSError of the block into a :class:`WriteError` that names the place."""
    try:
        yield
    except OSError as error:
        raise WriteError(f"{place} cannot be written: {error.strerror or error}") from error


def _sync(folder: Path) -> None:
    """Flush the directory entries of a folder to the disk."""
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def ignore_closed_pipes() -> None:
    """Make a write to a closed pipe raise BrokenPipeError, as Python does by default.

    PETSc handles SIGPIPE itself, and gmsh restores its default, which ends the process: call this
    after either is initialised. Only the main thread can set signals; elsewhere nothing changes.
    """
    if hasattr(signal, "SIGPIPE") and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
