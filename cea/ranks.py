"""Agreement between ranks, so that a fault on one leaves no other waiting."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from cea.errors import InputError


@contextmanager
def agreed(comm: Any) -> Iterator[None]:
    """Run a block that sends no messages; input that any rank refuses, every rank refuses.

    Parameters
    ----------
    comm
        MPI communicator (mpi4py); leaving the block is collective.

    Raises
    ------
    InputError
        That of the lowest rank whose block raised one.
    """
    refusal = None
    try:
        yield
    except InputError as error:
        refusal = error
    first = next((r for r in comm.allgather(refusal) if r is not None), None)
    if first is not None:
        raise first


def made_on_first[T](comm: Any, make: Callable[[], T]) -> T | None:
    """What a function makes on rank 0, None on the others; what it raises there, all ranks raise.

    Parameters
    ----------
    comm
        MPI communicator (mpi4py); the call is collective.
    make
        The function; it sends no messages.
    """
    made: T | None = None
    fault: Exception | None = None
    if comm.rank == 0:
        try:
            made = make()
        except Exception as error:
            fault = error
    fault = comm.bcast(fault, root=0)
    if fault is not None:
        raise fault
    return made


def local_rows(n: int, comm: Any) -> tuple[int, int]:
    """First row of this rank and of the next, when n rows are shared out evenly."""
    return comm.rank * n // comm.size, (comm.rank + 1) * n // comm.size
