"""Tall columns whose number grows: they lie in pieces, and those that are there stay in place.

One array would have to be copied each time it became too small, and fresh memory is dear.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.eigen.dense_products import combined, subtract

_FEW, _GROWTH = 128, 0.5
"""Least columns of a further piece, and part of all before it that a large one has."""


class Columns:
    """Columns in pieces, each in Fortran order.

    Parameters
    ----------
    first
        Those that are there from the start, shape (n_local, k); they are not copied, and not to be
        written.
    most
        Most columns that will follow.
    dtype
        Of all columns, float or complex.
    few
        Least columns of a further piece.
    """

    def __init__(self, first: NDArray[Any], most: int, dtype: type, *, few: int = _FEW) -> None:
        self._pieces: list[NDArray[Any]] = [np.asfortranarray(first, dtype=dtype)]
        self._most, self._few = first.shape[1] + most, few

    def put(self, start: int, block: NDArray[Any]) -> None:
        """Write columns from a place on; behind the last there is room for more."""
        stop = start + block.shape[1]
        if stop > (there := self._room()):
            wanted = max(self._few, int(_GROWTH * there))
            columns = max(stop - there, min(wanted, self._most - there))
            rows, dtype = len(self._pieces[0]), self._pieces[0].dtype
            self._pieces.append(np.empty((rows, columns), dtype=dtype, order="F"))
        for columns_of_block, part in self._parts(start, stop):
            part[:] = block[:, columns_of_block]

    def take(self, start: int, stop: int) -> NDArray[Any]:
        """Columns as one array: where they are, or a copy where they lie in two pieces."""
        parts = [part for _, part in self._parts(start, stop)]
        if len(parts) == 1:
            return parts[0]
        shape = (len(self._pieces[0]), stop - start)
        whole: NDArray[Any] = np.empty(shape, dtype=self._pieces[0].dtype, order="F")
        for columns, part in self._parts(start, stop):
            whole[:, columns] = part
        return whole

    def inner(
        self,
        stop: int,
        right: NDArray[Any],
        product: Callable[[NDArray[Any], NDArray[Any]], NDArray[Any]],
    ) -> NDArray[Any]:
        """Inner products of the columns up to one with those of a block, shape (stop, columns).

        Parameters
        ----------
        stop, right
            Number of columns, and the block.
        product
            Inner products of every column of one block with every column of another.
        """
        result: NDArray[Any] = np.zeros((stop, right.shape[1]), dtype=right.dtype)
        for columns, part in self._parts(0, stop):
            result[columns] = product(part, right)
        return result

    def subtract(self, block: NDArray[Any], coefficients: NDArray[Any]) -> None:
        """Subtract the first columns times coefficients from a block in Fortran order, in place."""
        for columns, part in self._parts(0, len(coefficients)):
            subtract(block, part, coefficients[columns])

    def combined(self, start: int, coefficients: NDArray[Any]) -> NDArray[Any]:
        """So many columns from a place on times coefficients, a new block in Fortran order."""
        total: NDArray[Any] | None = None
        for columns, part in self._parts(start, start + len(coefficients)):
            if total is None:
                total = combined(part, coefficients[columns])
            else:
                subtract(total, part, -coefficients[columns])
        if total is None:
            shape = (len(self._pieces[0]), coefficients.shape[1])
            total = np.zeros(shape, dtype=self._pieces[0].dtype, order="F")
        return total

    def _room(self) -> int:
        """Columns that the pieces have room for."""
        return sum(piece.shape[1] for piece in self._pieces)

    def _parts(self, start: int, stop: int) -> Iterator[tuple[slice, NDArray[Any]]]:
        """Where columns lie: their numbers, counted from the start, and the part of a piece."""
        before = 0
        for piece in self._pieces:
            own = slice(max(start - before, 0), min(stop - before, piece.shape[1]))
            if own.start < own.stop:
                at = before + own.start - start
                yield slice(at, at + own.stop - own.start), piece[:, own]
            before += piece.shape[1]
