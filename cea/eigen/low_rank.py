"""Symmetric pieces of a pencil of low rank, W diag(d) W^T, that are never formed as matrices.

Modal damping is one: as a matrix it would be full on its body. Systems with A + s B B^T, B of few
columns, are solved by factors of A (Sherman, Morrison and Woodbury):

    (A + s B B^T)^-1 = A^-1 - s Z (1 + s B^T Z)^-1 B^T A^-1,     Z = A^-1 B

Where A is nearly singular and the sum is not, digits cancel in the difference. Steps of iterative
refinement bring them back; how many it takes is measured once, on a solution that is known.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import column_blocks, image_of, norms, transposed_times
from cea.eigen.mumps import Mumps
from cea.eigen.parameters import CONSTANT, Dependence
from cea.errors import ConvergenceError
from cea.petsc import MPI

_MOST_STEPS = 8
"""Most steps of refinement."""
_WORTH, _EXACT = 3.0, 1e-13
"""Factor by which more steps must lessen an error to be taken, and one that is small enough."""
_UNSOLVED = 1e-2
"""Relative error of a known solution beyond which the sum counts as singular."""


@dataclass(frozen=True)
class LowRank:
    """W diag(d) W^T on some of the displacements.

    Parameters
    ----------
    vectors
        W, the rows of this rank that are not zero, shape (m, r).
    weights
        d, none below zero, the same on every rank, shape (r,).
    first
        Number of the first of these rows among the displacements of this rank.
    """

    vectors: Floats
    weights: Floats
    first: int = 0

    @property
    def rows(self) -> slice:
        """Its rows among the displacements of this rank."""
        return slice(self.first, self.first + len(self.vectors))

    def times(self, x: NDArray[Any], comm: Any) -> NDArray[Any]:
        """The rows of it that are not zero, times a block of vectors, the rows of this rank.

        Parameters
        ----------
        x
            Shape (n_local, columns), real or complex.
        comm
            Communicator (petsc4py).
        """
        return of_real(self.vectors, self.weights[:, None] * self.inner(x, comm))

    def inner(self, x: NDArray[Any], comm: Any) -> NDArray[Any]:
        """W^T x, shape (r, columns)."""
        return comm.tompi4py().allreduce(of_real(self.vectors.T, x[self.rows]))

    def projected(self, left: Complexes, right: Complexes, comm: Any) -> Complexes:
        """Y^H W diag(d) W^T X, shape (columns of Y, columns of X)."""
        return self.inner(left, comm).conj().T @ (self.weights[:, None] * self.inner(right, comm))


@dataclass(frozen=True)
class LowRankTerm:
    """A piece of the damping of a pencil: c(t) W diag(d) W^T.

    Parameters
    ----------
    piece
        W and d.
    coefficient
        c, nowhere below zero.
    """

    piece: LowRank
    coefficient: Dependence = CONSTANT


@dataclass(frozen=True)
class LowRankSum:
    """A sum of pieces of low rank, symmetric and positive semidefinite.

    Parameters
    ----------
    pieces
        The pieces.
    rows
        Displacements of this rank.
    comm
        Communicator (petsc4py).
    """

    pieces: tuple[LowRank, ...]
    rows: int
    comm: Any

    def times(self, x: NDArray[Any]) -> NDArray[Any]:
        """It times a block of vectors, the rows of this rank, shape (n_local, columns)."""
        result = np.zeros_like(x)
        for piece in self.pieces:
            result[piece.rows] += piece.times(x, self.comm)
        return result

    def sizes(self, x: Floats) -> Floats:
        """abs(W) diag(d) abs(W)^T x: what rounding the entries of W is relative to."""
        result = np.zeros_like(x)
        for piece in self.pieces:
            positive = LowRank(np.abs(piece.vectors), piece.weights, piece.first)
            result[piece.rows] += positive.times(x, self.comm)
        return result

    def root(self) -> Floats:
        """B with B B^T equal to it, the rows of this rank, shape (n_local, r)."""
        kept = [piece.weights > 0 for piece in self.pieces]
        columns = np.cumsum([0, *(int(each.sum()) for each in kept)])
        root = np.zeros((self.rows, columns[-1]), order="F")
        for piece, own, start, stop in zip(self.pieces, kept, columns, columns[1:], strict=False):
            root[piece.rows, start:stop] = piece.vectors[:, own] * np.sqrt(piece.weights[own])
        return root


def sum_of(parts: Iterable[tuple[float, LowRank]], rows: int, comm: Any) -> LowRankSum | None:
    """Sum of factors times pieces; those that are zero are left out, None where all are.

    Parameters
    ----------
    parts
        Factors, none below zero, and pieces.
    rows, comm
        As of :class:`LowRankSum`.
    """
    kept = tuple(
        LowRank(piece.vectors, factor * piece.weights, piece.first)
        for factor, piece in parts
        if factor != 0 and piece.weights.any()
    )
    return LowRankSum(kept, rows, comm) if kept else None


def of_real(matrix: Floats, block: NDArray[Any]) -> NDArray[Any]:
    """A real matrix times a block that may be complex, of which no complex copy is made."""
    if not np.iscomplexobj(block):
        return matrix @ block
    parts = np.ascontiguousarray(block).view(np.float64)
    return np.ascontiguousarray(matrix @ parts).view(np.complex128)


class LowRankUpdate:
    """A + s B B^T, solved by means of A.

    Parameters
    ----------
    matrix
        A factorised.
    root
        B, the first rows of this rank, shape (m, r); A may have more rows, where B is zero.
    shift
        s.
    symmetric
        Whether A is symmetric.

    Raises
    ------
    ConvergenceError
        When A or the sum is singular, or as good as that.
    """

    def __init__(
        self,
        matrix: Mumps,
        root: Floats,
        shift: float,
        *,
        symmetric: bool,
    ) -> None:
        self._matrix, self._root, self._shift = matrix, root, shift
        self._rows, self._symmetric = matrix.matrix.getLocalSize()[0], symmetric
        self._comm = matrix.matrix.comm
        self._sides: dict[bool, _Side] = {}
        self._side(transposed=False)

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
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
            [self._matrix.solve_block(whole[:, each], transposed=transposed) for each in blocks]
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
        known = self._matrix.solve_block(start, transposed=side.transposed)
        known = np.asfortranarray(known / norms(known, self._comm))
        b, x, errors = self._times(side, known), np.zeros_like(known), []
        for _ in range(_MOST_STEPS + 1):
            x = x + self._once(side, b - self._times(side, x))
            error = float(norms(x - known, self._comm)[0])
            errors.append(error if np.isfinite(error) else np.inf)
        return errors

    def _once(self, side: "_Side", b: Floats) -> Floats:
        """Solutions without refinement."""
        x = self._matrix.solve_block(b, transposed=side.transposed)
        parts = lu_solve(side.small, self._inner(x), check_finite=False)
        return x - side.image @ (self._shift * parts)

    def _times(self, side: "_Side", x: Floats) -> Floats:
        """(A + s B B^T) x, or with A^T."""
        product = transposed_times if side.transposed else image_of
        result: Floats = product(self._matrix.matrix, x)
        result[: len(self._root)] += self._shift * (self._root @ self._inner(x))
        return result

    def _inner(self, x: Floats) -> Floats:
        """B^T x, the same on every rank."""
        return np.asarray(self._comm.tompi4py().allreduce(self._root.T @ x[: len(self._root)]))


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
    image: Floats
    small: tuple[Any, Any]
    steps: int = 0
