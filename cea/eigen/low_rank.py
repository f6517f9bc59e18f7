"""Symmetric pieces of a pencil of low rank, W diag(d) W^T, that are never formed as matrices.

Modal damping is one: as a matrix it would be full on its body.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.parameters import CONSTANT, Dependence


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
        """The rows of it that are not zero, times a block of vectors, the rows of this rank."""
        return _product(self.vectors, self.weights[:, None] * self.inner(x, comm))

    def inner(self, x: NDArray[Any], comm: Any) -> NDArray[Any]:
        """W^T x, shape (r, columns)."""
        return np.asarray(comm.tompi4py().allreduce(_product(self.vectors.T, x[self.rows])))

    def projected(self, left: Complexes, right: Complexes, comm: Any) -> Complexes:
        """Y^H W diag(d) W^T X, shape (columns of Y, columns of X)."""
        return self.inner(left, comm).conj().T @ (self.weights[:, None] * self.inner(right, comm))


@dataclass(frozen=True)
class LowRankTerm:
    """A piece of the damping of a pencil: c(t) W diag(d) W^T, c nowhere below zero."""

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
        parts = [np.zeros((self.rows, 0))]
        for piece in self.pieces:
            own = piece.weights > 0
            parts.append(np.zeros((self.rows, int(own.sum()))))
            parts[-1][piece.rows] = piece.vectors[:, own] * np.sqrt(piece.weights[own])
        return np.asfortranarray(np.hstack(parts))


def sum_of(parts: Iterable[tuple[float, LowRank]], rows: int, comm: Any) -> LowRankSum | None:
    """Sum of factors, none below zero, times pieces; None where all are zero."""
    kept = tuple(
        LowRank(piece.vectors, factor * piece.weights, piece.first)
        for factor, piece in parts
        if factor != 0 and piece.weights.any()
    )
    return LowRankSum(kept, rows, comm) if kept else None


def _product(matrix: Floats, block: NDArray[Any]) -> NDArray[Any]:
    """A real matrix times a block that may be complex, of which no complex copy is made."""
    if not np.iscomplexobj(block):
        return matrix @ block
    return matrix @ block.real + 1j * (matrix @ block.imag)
