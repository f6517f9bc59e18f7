"""Systems with A + E by factors of A, as a Neumann series: E is small beside A.

    (A + E)^-1 b = d_0 + d_1 + ...,    d_0 = A^-1 b,    d_k+1 = - A^-1 E d_k

How many terms it takes is measured once, on a solution in which what is nearly singular stands out.
"""

from typing import Any, Protocol

import numpy as np

from cea.arrays import Floats
from cea.eigen.blocks import norms
from cea.eigen.circulatory import CirculatorySum
from cea.errors import ConvergenceError

_MOST = 6
"""Most terms beyond the first: factors of a larger matrix that has E in it cost less than more."""
_NEGLIGIBLE = 1e-13
"""Size of a term, relative to the first, that is left out."""


class Solver(Protocol):
    """A matrix A that systems are solved with."""

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """A^-1 b, or A^-T b, for every column: the rows of this rank, shape (n_local, columns)."""
        ...


class NeumannSeries:
    """A + E, solved by means of A.

    Parameters
    ----------
    matrix
        A.
    rest
        E, on the first rows.
    rows, local
        Rows of A and of E on this rank.
    comm
        Communicator (petsc4py).

    Raises
    ------
    ConvergenceError
        When that takes too many terms.
    """

    def __init__(
        self, matrix: Solver, rest: CirculatorySum, *, rows: int, local: int, comm: Any
    ) -> None:
        self._matrix, self._rest = matrix, rest
        self._rows, self._local, self._comm = rows, local, comm
        self._terms = self._needed()

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """Solutions for every column of b, the rows of this rank, shape (rows, columns)."""
        x = term = self._matrix.solve_block(b, transposed=transposed)
        for _ in range(self._terms):
            term = self._next(term, transposed=transposed)
            x = x + term
        return x

    def _next(self, term: Floats, *, transposed: bool) -> Floats:
        load = np.zeros_like(term)
        load[: self._local] = -self._rest.times(term[: self._local], transposed=transposed)
        return self._matrix.solve_block(load, transposed=transposed)

    def _needed(self) -> int:
        """Terms beyond the first that count, of the matrix and of its transposed."""
        start = np.random.default_rng([2, self._comm.rank]).standard_normal((self._rows, 1))
        needed = 0
        for transposed in (False, True):
            term = self._matrix.solve_block(start, transposed=transposed)
            first = size = float(norms(term, self._comm)[0])
            for count in range(_MOST + 1):
                term = self._next(term, transposed=transposed)
                before, size = size, float(norms(term, self._comm)[0])
                if size <= _NEGLIGIBLE * first:
                    needed = max(needed, count)
                    break
                if not size < before:
                    raise ConvergenceError("a Neumann series that does not converge")
            else:
                raise ConvergenceError(f"a Neumann series of more than {_MOST} terms")
        return needed
