"""Agreement between ranks, so that a fault on one leaves no other waiting."""

import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


class FaultOnRankError(RuntimeError):
    """A fault on another rank that cannot travel as it is: its kind and its words."""


@contextmanager
def agreed(comm: Any) -> Iterator[None]:
    """Run a block that sends no messages; a fault on any rank ends it on every rank; collective."""
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
    """What a function makes on rank 0, None on others; every rank raises what it raises there."""
    with agreed(comm):
        return make() if comm.rank == 0 else None


def local_rows(n: int, comm: Any) -> tuple[int, int]:
    """First row of this rank and of the next, when n rows are shared out evenly."""
    return comm.rank * n // comm.size, (comm.rank + 1) * n // comm.size


def _travelling(fault: Exception | None) -> Exception | None:
    """A fault as it can be sent: some do not survive being packed."""
    if fault is None:
        return None
    try:
        unpacked = pickle.loads(pickle.dumps(fault))
    except Exception:
        unpacked = None
    if type(unpacked) is type(fault) and str(unpacked) == str(fault):
        return fault
    return FaultOnRankError(f"{type(fault).__name__}: {fault}")
