"""Systems with A + s B B^T by factors of A, B of few columns (Sherman, Morrison and Woodbury).

    (A + s B B^T)^-1 = A^-1 - s Z (1 + s B^T Z)^-1 B^T A^-1,     Z = A^-1 B

Where A is nearly singular and the sum is not, digits cancel in the difference. Steps of iterative
refinement bring them back; how many it takes is measured once, on a solution that is known.
"""

from typing import Any, Protocol
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve

from cea.body import Floats
from cea.eigen.blocks import column_blocks, norms
from cea.eigen.low_rank import of_real
from cea.errors import ConvergenceError
from cea.petsc import MPI

_MOST_STEPS = 4
"""Most steps of refinement."""
_WORTH = 3.0
"""Factor on an error by which more steps must lessen it to be taken."""
_UNSOLVED = 1e-2
"""Relative error of a known solution beyond which the sum counts as singular."""


class Blocks(Protocol):
    """A matrix A that is multiplied with blocks, and with its inverse."""

    def times(self, x: NDArray[Any], *, transposed: bool) -> NDArray[Any]:
        """A x, or A^T x, for every column: the rows of this rank, shape (n_local, columns)."""
        ...

    def solve(self, b: NDArray[Any], *, transposed: bool) -> NDArray[Any]:
        """A^-1 b, or A^-T b, for every column."""
        ...


class LowRankUpdate:
    """A + s B B^T, solved by means of A.

    Parameters
    ----------
    matrix
        A.
    root
        B, the first rows of this rank, shape (m, r); A may have more rows, where B is zero.
    shift
        s, real or complex.
    rows
        Rows of A on this rank.
    symmetric
        Whether A is symmetric, complex or not.
    comm
        Communicator (petsc4py).

    Attributes
    ----------
    steps
        Steps of refinement that each system takes.

    Raises
    ------
    ConvergenceError
        When A or the sum is singular, or as good as that.
    """

    def __init__(
        self,
        matrix: Blocks,
        root: Floats,
        shift: complex,
        *,
        rows: int,
        symmetric: bool,
        comm: Any,
    ) -> None:
        self._matrix, self._root, self._shift = matrix, root, shift
        self._rows, self._symmetric, self._comm = rows, symmetric, comm
        self._images: dict[bool, NDArray[Any]] = {}
        self._small: Any = None
        self.steps = 0
        self._prepare()

    def solve(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Solutions for every column of b, the rows of this rank, shape (rows, columns)."""
        x = self._once(b, transposed=transposed)
        for _ in range(self.steps):
            x = x + self._once(b - self._times(x, transposed=transposed), transposed=transposed)
        return x

    def sign(self) -> int:
        """Sign of det(A + s B B^T) / det A at a real shift."""
        factors, pivots = self._small
        swaps = int((pivots != np.arange(len(pivots))).sum())
        return int(np.prod(np.sign(np.diag(factors)))) * (-1) ** swaps

    def _prepare(self) -> None:
        """The small matrix, and the steps that a known solution takes."""
        image = self._image(transposed=False)
        finite = self._comm.tompi4py().allreduce(bool(np.isfinite(image).all()), MPI.LAND)
        errors = [np.inf]
        if finite:
            with catch_warnings():
                simplefilter("ignore", LinAlgWarning)  # a singular one solves nothing below
                small = np.eye(image.shape[1]) + self._shift * self._inner(image)
                self._small = lu_factor(small, check_finite=False)
            errors = self._errors()
        least = min(errors)
        if not least <= _UNSOLVED:
            columns = self._root.shape[1]
            raise ConvergenceError(f"a matrix is singular with one of rank {columns}, or without")
        self.steps = next(i for i, each in enumerate(errors) if each <= _WORTH * least)

    def _errors(self) -> list[float]:
        """Relative errors of a solution after no step of refinement, after one, and so on.

        The solution is one of the systems themselves, in which all that is nearly singular stands
        out.
        """
        rng = np.random.default_rng([1, self._comm.rank])
        known = self._matrix.solve(rng.standard_normal((self._rows, 1)), transposed=False)
        known = known / norms(known, self._comm)
        b, x, errors = self._times(known, transposed=False), np.zeros_like(known), []
        for _ in range(_MOST_STEPS + 1):
            x = x + self._once(b - self._times(x, transposed=False), transposed=False)
            error = float(norms(x - known, self._comm)[0])
            errors.append(error if np.isfinite(error) else np.inf)
        return errors

    def _once(self, b: NDArray[Any], *, transposed: bool) -> NDArray[Any]:
        """Solutions without refinement."""
        x = self._matrix.solve(b, transposed=transposed)
        parts = lu_solve(self._small, self._inner(x), trans=int(transposed), check_finite=False)
        return x - self._image(transposed=transposed) @ (self._shift * parts)

    def _times(self, x: NDArray[Any], *, transposed: bool) -> NDArray[Any]:
        """(A + s B B^T) x."""
        result = self._matrix.times(x, transposed=transposed).astype(
            np.result_type(x, self._shift), copy=False
        )
        result[: len(self._root)] += self._shift * of_real(self._root, self._inner(x))
        return result

    def _inner(self, x: NDArray[Any]) -> NDArray[Any]:
        """B^T x, the same on every rank."""
        inner = of_real(self._root.T, x[: len(self._root)])
        return self._comm.tompi4py().allreduce(inner)

    def _image(self, *, transposed: bool) -> NDArray[Any]:
        """Z of A or of A^T, the rows of this rank."""
        which = transposed and not self._symmetric
        if which not in self._images:
            whole = np.zeros((self._rows, self._root.shape[1]), order="F")
            whole[: len(self._root)] = self._root
            self._images[which] = np.hstack(
                [
                    self._matrix.solve(whole[:, block], transposed=which)
                    for block in column_blocks(whole.shape[1])
                ]
            )
        return self._images[which]
