"""What cells of one rank add to rows of another, added there in the order of the ranks."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats

Entries = NDArray[np.integer[Any]]


class Exchange:
    """Entries that ranks send each other.

    Parameters
    ----------
    comm
        Communicator (mpi4py).
    sent
        For each rank the entries it gets, counted among those that are sent.
    taken
        For each rank the entries of this one that its go to, each at most once.
    """

    def __init__(self, comm: Any, sent: Sequence[slice], taken: Sequence[Entries]) -> None:
        self._comm = comm
        self._sent = sent
        self._taken = taken
        ahead = taken[: comm.rank]
        self._ahead = (
            ahead[0] if len(ahead) == 1 else np.unique(np.concatenate([*ahead, taken[-1][:0]]))
        )

    def add(
        self, data: Floats, beyond: Floats, places: Callable[[Entries], Entries] = lambda e: e
    ) -> None:
        """Send what belongs to others, and add what they send; collective.

        Every place of the data is a sum over the ranks by rising number: an entry and its mirror
        image, of another rank maybe, are the same to the last bit.

        Parameters
        ----------
        data
            Values of this rank, flat, to which is added.
        beyond
            Values that are sent, shape (entries, ...).
        places
            Where in the data the values of entries go, shape (entries, ...).
        """
        if self._comm.size == 1:
            return
        came = self._comm.alltoall([beyond[part] for part in self._sent])
        targets = [places(entries) for entries in self._taken]
        rank = self._comm.rank
        ahead = places(self._ahead)
        own = data[ahead]
        data[ahead] = 0.0
        for number, (target, values) in enumerate(zip(targets, came, strict=True)):
            if number == rank:
                data[ahead] += own
            data[target] += values
