"""Factors in files of a temporary folder instead of memory: slower to solve with, if at all.

What is factorised inside of :func:`factors_on_disk` is written to files, each rank's to a folder of
its own, and read again at every solve; the system keeps as much of them in memory as is left. A
folder is locked while it is in use: those that killed programs left behind are removed.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from fcntl import LOCK_EX, LOCK_NB, flock
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory, gettempdir
from time import time

_FOLDER: ContextVar[Path | None] = ContextVar("folder of factors", default=None)
_PREFIX, _LOCK = "factors-", "in_use"
_NEW = 60.0
"""Age (s) up to which a folder may be about to be locked."""


def folder_of_factors() -> Path | None:
    """Where factors are written now; None where they stay in memory."""
    return _FOLDER.get()


@contextmanager
def factors_on_disk() -> Iterator[Path]:
    """Keep factors on disk while this lasts; they must be freed before it ends."""
    _remove_left_behind(Path(gettempdir()))
    with TemporaryDirectory(prefix=_PREFIX) as name, (Path(name) / _LOCK).open("w") as lock:
        flock(lock, LOCK_EX)
        token = _FOLDER.set(Path(name))
        try:
            yield Path(name)
        finally:
            _FOLDER.reset(token)


def _remove_left_behind(parent: Path) -> None:
    """Remove folders of factors that no program uses any more."""
    for path in parent.glob(f"{_PREFIX}*/{_LOCK}"):
        with suppress(OSError):  # in use, of somebody else, or just removed
            if time() - path.stat().st_mtime > _NEW:
                with path.open() as lock:
                    flock(lock, LOCK_EX | LOCK_NB)
                    rmtree(path.parent)
