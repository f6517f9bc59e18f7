"""Files and folders written whole or not at all: what is killed or fails leaves nothing half made.

Content goes to a hidden name beside its place and to the disk, and only then takes its place.
"""

import errno
import gzip
import os
import shutil
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cea.errors import InputError, WriteError

_LEVEL = 6  # level of compression: the highest takes three times as long and saves a few per cent


def write_whole(content: bytes, file: Path) -> Path:
    """Write a file whole or not at all, making its folder."""
    if file.suffix == ".gz":
        content = gzip.compress(content, _LEVEL, mtime=0)
    part = _hidden(file, "part")
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
    """A file that may be read: devices and pipes may have no end."""
    if file.exists() and not file.is_file():
        raise OSError(errno.EINVAL, "not a regular file", str(file))
    return file


def check_writable(file: Path, field: str) -> None:
    """Refuse a file that cannot be written, before the work whose result it is to hold."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        regular(file)
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or error
        raise InputError(field, str(file), f"a file to write ({reason})") from None
    if not os.access(file.parent, os.W_OK):
        raise InputError(field, str(file), "a file to write, in a folder that may be written")


@contextmanager
def folder_whole(folder: Path) -> Iterator[Path]:
    """A new folder to fill, which takes the place of a folder when the block ends without error."""
    part, old = _hidden(folder, "part"), _hidden(folder, "old")
    try:
        with _told(folder):
            for left in (part, old):
                shutil.rmtree(left, ignore_errors=True)
            part.mkdir(parents=True)
        yield part
        with _told(folder):
            _sync(part)
            if folder.exists():
                folder.replace(old)
            part.replace(folder)
            _sync(folder.parent)
    finally:
        if old.exists() and not folder.exists():
            old.replace(folder)
        for left in (part, old):
            shutil.rmtree(left, ignore_errors=True)


@contextmanager
def _told(place: Path) -> Iterator[None]:
    """Tell faults of the disk by the place that was to be written."""
    try:
        yield
    except OSError as error:
        raise WriteError(f"{place} cannot be written: {error.strerror or error}") from error


def _hidden(place: Path, what: str) -> Path:
    return place.with_name(f".{place.name}.{os.getpid()}.{what}")


def _sync(folder: Path) -> None:
    """Bring the names in a folder to the disk."""
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def ignore_closed_pipes() -> None:
    """Let a write to a closed pipe raise BrokenPipeError, as Python does.

    PETSc catches the signal that such a write sends, and gmsh leaves it to end the process: to be
    called after either begins. Signals belong to the main thread; elsewhere nothing changes.
    """
    if hasattr(signal, "SIGPIPE") and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
