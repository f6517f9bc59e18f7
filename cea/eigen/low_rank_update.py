"""Systems with A + s B B^T by factors of A, B of few columns (Sherman, Morrison and Woodbury).

    (A + s B B^T)^-1 = A^-1 - s Z (1 + s B^T Z)^-1 B^T A^-1,     Z = A^-1 B

Where A is nearly singular and the sum is not, digits cancel in the difference. Steps of iterative
refinement bring them back; how many it takes is measured once, on a solution that is known.
"""

from dataclasses import dataclass, replace
from typing import Any, Protocol
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve

from cea.arrays import Floats
from cea.eigen.blocks import column_blocks, norms
from cea.eigen.low_rank import of_real
from cea.errors import ConvergenceError
from cea.petsc import MPI

_MOST_STEPS = 8
"""Most steps of refinement."""
_WORTH, _EXACT = 3.0, 1e-13
"""Factor by which more steps must lessen an error to be taken, and one that is small enough."""
_UNSOLVED = 1e-2
"""Relative error of a known solution beyond which the sum counts as singular."""


class Solver(Protocol):
    """A matrix A that systems are solved with."""

    def solve(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """A^-1 b, or A^-T b, for every column: the rows of this rank, shape (n_local, columns)."""
        ...


class Blocks(Solver, Protocol):
    """A matrix A that is multiplied with blocks, and with its inverse."""

    def times(self, x: NDArray[Any], *, transposed: bool) -> NDArray[Any]:
        """A x, or A^T x, for every column."""
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
        self._sides: dict[bool, _Side] = {}
        self._side(transposed=False)

    def solve(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Solutions for every column of b, the rows of this rank, shape (rows, columns)."""
        side = self._side(transposed=transposed)
        x = self._once(side, b)
        for _ in range(side.steps):
            x = x + self._once(side, b - self._times(side, x))
        return x

    def steps(self, *, transposed: bool = False) -> int:
        """Steps of refinement that each system takes."""
        return self._side(transposed=transposed).steps

    def sign(self) -> int:
        """Sign of det(A + s B B^T) / det A at a real shift."""
        factors, pivots = self._side(transposed=False).small
        swaps = int((pivots != np.arange(len(pivots))).sum())
        return int(np.prod(np.sign(np.diag(factors)))) * (-1) ** swaps

    def _side(self, *, transposed: bool) -> "_Side":
        """What solves with the sum, or with its transposed.

        Rounding of Z and of the small matrix go together: with that of A the formula for A^T would
        be unstable.
        """
        transposed = transposed and not self._symmetric
        if transposed not in self._sides:
            self._sides[transposed] = self._prepared(transposed=transposed)
        return self._sides[transposed]

    def _prepared(self, *, transposed: bool) -> "_Side":
        whole = np.zeros((self._rows, self._root.shape[1]), order="F")
        whole[: len(self._root)] = self._root
        blocks = column_blocks(whole.shape[1])
        image = np.hstack(
            [self._matrix.solve(whole[:, each], transposed=transposed) for each in blocks]
        )
        finite = self._comm.tompi4py().allreduce(bool(np.isfinite(image).all()), MPI.LAND)
        errors = [np.inf]
        if finite:
            with catch_warnings():
                simplefilter("ignore", LinAlgWarning)  # a singular one solves nothing below
                small = np.eye(image.shape[1]) + self._shift * self._inner(image)
                side = _Side(transposed, image, lu_factor(small, check_finite=False))
            errors = self._errors(side)
        least = min(errors)
        if not least <= _UNSOLVED:
            rank = self._root.shape[1]
            raise ConvergenceError(f"a matrix is singular with one of rank {rank}, or without")
        enough = max(_WORTH * least, _EXACT)
        return replace(side, steps=next(i for i, each in enumerate(errors) if each <= enough))

    def _errors(self, side: "_Side") -> list[float]:
        """Relative errors of a solution after no step of refinement, after one, and so on.

        The solution is one of systems with A, in which what is nearly singular stands out.
        """
        rng = np.random.default_rng([1, self._comm.rank])
        start = rng.standard_normal((self._rows, 1))
        known = self._matrix.solve(start, transposed=side.transposed)
        known = known / norms(known, self._comm)
        b, x, errors = self._times(side, known), np.zeros_like(known), []
        for _ in range(_MOST_STEPS + 1):
            x = x + self._once(side, b - self._times(side, x))
            error = float(norms(x - known, self._comm)[0])
            errors.append(error if np.isfinite(error) else np.inf)
        return errors

    def _once(self, side: "_Side", b: NDArray[Any]) -> NDArray[Any]:
        """Solutions without refinement."""
        x = self._matrix.solve(b, transposed=side.transposed)
        parts = lu_solve(side.small, self._inner(x), check_finite=False)
        return x - side.image @ (self._shift * parts)

    def _times(self, side: "_Side", x: NDArray[Any]) -> NDArray[Any]:
        """(A + s B B^T) x, or with A^T."""
        kind = np.result_type(x, self._shift)
        result = self._matrix.times(x, transposed=side.transposed).astype(kind, copy=False)
        result[: len(self._root)] += self._shift * of_real(self._root, self._inner(x))
        return result

    def _inner(self, x: NDArray[Any]) -> NDArray[Any]:
        """B^T x, the same on every rank."""
        inner = of_real(self._root.T, x[: len(self._root)])
        return self._comm.tompi4py().allreduce(inner)


@dataclass(frozen=True)
class _Side:
    """What solves with A + s B B^T, or with A^T + s B B^T.

    Parameters
    ----------
    transposed
        Whether with the latter.
    image
        Z, the rows of this rank, shape (rows, r).
    small
        1 + s B^T Z factorised.
    steps
        Steps of refinement.
    """

    transposed: bool
    image: NDArray[Any]
    small: tuple[NDArray[Any], NDArray[Any]]
    steps: int = 0
