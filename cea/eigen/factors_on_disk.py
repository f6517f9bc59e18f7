"""Factors in files of a temporary folder instead of memory: slower to solve with, if at all.

What is factorised inside of :func:`factors_on_disk` is written to files, each rank's to a folder of
its own, and read again at every solve; the system keeps as much of them in memory as is left.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from tempfile import TemporaryDirectory

_FOLDER: ContextVar[Path | None] = ContextVar("folder of factors", default=None)


def folder_of_factors() -> Path | None:
    """Where factors are written now; None where they stay in memory."""
    return _FOLDER.get()


@contextmanager
def factors_on_disk() -> Iterator[Path]:
    """Keep factors on disk while this lasts; they must be freed before it ends."""
    with TemporaryDirectory(prefix="factors-") as name:
        token = _FOLDER.set(Path(name))
        try:
            yield Path(name)
        finally:
            _FOLDER.reset(token)
