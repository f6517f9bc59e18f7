"""Pieces of a pencil that are never formed as matrices, for they would be full ones.

Symmetric pieces of the damping of low rank, W diag(d) W^T: modal damping is one. Circulatory pieces
of the stiffness, L N^-1 J: damping that rotates with its body makes one of them of displacements at
rest in space (:mod:`cea.rotation`), skew but for what a mesh makes of it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import times, transposed_times
from cea.eigen.mumps import Mumps
from cea.eigen.parameters import CONSTANT, Dependence
from cea.matrices import absolute, destroy
from cea.petsc import Mat


@dataclass(frozen=True)
class LowRank:
    """W diag(d) W^T, d >= 0 of shape (r,), on some of the displacements.

    ``vectors`` are the rows of W of this rank that are not zero, from the first displacement on.
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
    """A sum of pieces of low rank, positive semidefinite, on the displacements of this rank."""

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


@dataclass(frozen=True)
class Circulatory:
    """L N^-1 J on the displacements, PETSc AIJ (n x m, m x m, m x n), N positive definite."""

    left: Mat
    middle: Mat
    right: Mat

    def times(self, x: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """It, or J^T N^-1 L^T, times a block of vectors, the rows of this rank."""
        if transposed:
            return transposed_times(self.right, self._solved(transposed_times(self.left, x)))
        return times(self.left, self.inner(x))

    def inner(self, x: NDArray[Any]) -> NDArray[Any]:
        """N^-1 J times a block of vectors, the rows of this rank."""
        return self._solved(times(self.right, x))

    def sizes(self, x: NDArray[Any]) -> Floats:
        """abs(L) abs(N^-1 J x), what the parts of its product with a block come to."""
        left = absolute(self.left)
        size = times(left, np.abs(self.inner(x)))
        destroy(left)
        return size

    @cached_property
    def balance(self) -> float:
        """Factor on J that makes it as large as L."""
        left, right = (float(np.max(matrix.norm())) for matrix in (self.left, self.right))
        return left / right if left and right else 1.0

    @cached_property
    def _factors(self) -> Mumps:
        return Mumps(self.middle.copy(), symmetric=True)

    def _solved(self, b: NDArray[Any]) -> NDArray[Any]:
        """N^-1 b for every column."""
        if np.iscomplexobj(b):
            return self._solved(b.real) + 1j * self._solved(b.imag)
        return self._factors.solve_block(np.asfortranarray(b))


@dataclass(frozen=True)
class CirculatoryTerm:
    """A circulatory piece of the stiffness of a pencil: c(t) L N^-1 J, c nowhere below zero."""

    piece: Circulatory
    coefficient: Dependence = CONSTANT


@dataclass(frozen=True)
class CirculatorySum:
    """A sum of factors above zero times circulatory pieces, at least one."""

    parts: tuple[tuple[float, Circulatory], ...]

    def times(self, x: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """It, or its transpose, times a block of vectors, the rows of this rank."""
        images = [factor * piece.times(x, transposed=transposed) for factor, piece in self.parts]
        return np.asfortranarray(sum(images[1:], images[0]))

    def symmetric(self, x: Floats) -> Floats:
        """Its symmetric part times a block."""
        return np.asfortranarray(0.5 * (self.times(x) + self.times(x, transposed=True)))

    def skew(self, x: Floats) -> Floats:
        """Its skew part times a block."""
        return np.asfortranarray(0.5 * (self.times(x) - self.times(x, transposed=True)))

    def sizes(self, x: NDArray[Any]) -> Floats:
        """What the parts of its product with a block come to."""
        sizes = [factor * piece.sizes(x) for factor, piece in self.parts]
        return np.asarray(sum(sizes[1:], sizes[0]))


def circulatory_sum(parts: Iterable[tuple[float, Circulatory]]) -> CirculatorySum | None:
    """Sum of factors times pieces; those that are zero are left out, None where all are."""
    kept = tuple(part for part in parts if part[0])
    return CirculatorySum(kept) if kept else None
