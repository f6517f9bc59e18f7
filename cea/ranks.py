"""Agreement between ranks, so that an error on one rank does not leave the others waiting."""

import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


class FaultOnRankError(RuntimeError):
    """An exception of another rank that cannot be pickled, with its type and message."""


@contextmanager
def agreed(comm: Any) -> Iterator[None]:
    """Run a block without communication; raise an error of any rank on every rank; collective."""
    fault = None
    try:
        yield
    except Exception as error:
        fault = error
    told = comm.allgather(_travelling(fault))
    first = next((rank for rank, one in enumerate(told) if one is not None), None)
    if first is not None:
        raise fault if first == comm.rank and fault is not None else told[first]


def made_on_first[T](comm: Any, make: Callable[[], T]) -> T | None:
    """Return the result of a function on rank 0, None elsewhere; all ranks raise its errors."""
    with agreed(comm):
        return make() if comm.rank == 0 else None


def local_rows(n: int, comm: Any) -> tuple[int, int]:
    """Return the first row of this rank and of the next, for n rows distributed evenly."""
    return comm.rank * n // comm.size, (comm.rank + 1) * n // comm.size


def _travelling(fault: Exception | None) -> Exception | None:
    """Return an exception that can be pickled, wrapping it if it cannot."""
    if fault is None:
        return None
    try:
        unpacked = pickle.loads(pickle.dumps(fault))
    except Exception:
        unpacked = None
    if type(unpacked) is type(fault) and str(unpacked) == str(fault):
        return fault
    return FaultOnRankError(f"{type(fault).__name__}: {fault}")
