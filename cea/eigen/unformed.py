"""Pieces of a pencil that are never formed as matrices, for they would be full ones.

Symmetric pieces of the damping of low rank, W diag(d) W^T: modal damping is one. Circulatory pieces
of the stiffness, L N^-1 J: damping that rotates with its body makes one of them of displacements at
rest in space (:mod:`cea.motion`), skew but for what a mesh makes of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.eigen.block_products import by_parts, times, transposed_times
from cea.eigen.coefficients import CONSTANT, Dependence
from cea.eigen.mumps import Mumps
from cea.matrices import destroy, distributed, identity, scaled_total
from cea.petsc import Mat, PETSc

type Unknowns = tuple[Mat, Mat, Mat]
"""J, L^T and N of a piece L N^-1 J, new matrices: its unknowns are w = N^-1 J x."""


@dataclass(frozen=True)
class UnformedTerm[Piece]:
    """c(t) times a piece, c nowhere below zero."""

    piece: Piece
    coefficient: Dependence = CONSTANT


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
        """It times a block of vectors, the rows of this rank."""

        def product(part: Floats) -> Floats:
            image = np.zeros_like(part)
            inner = comm.tompi4py().allreduce(self.vectors.T @ part[self.rows])
            image[self.rows] = self.vectors @ (self.weights[:, None] * inner)
            return image

        return by_parts(product, x)

    def sizes(self, x: Floats, comm: Any) -> Floats:
        """abs(W) diag(d) abs(W)^T x: what rounding the entries of W is relative to."""
        return LowRank(np.abs(self.vectors), self.weights, self.first).times(x, comm)

    def unknowns(self, factor: float, comm: Any) -> Unknowns:
        """Those of a factor times it, a symmetric piece whose vectors are all displacements."""
        columns: Any = (PETSc.DECIDE, self.vectors.shape[1])
        root = self.vectors * np.sqrt(factor * self.weights)
        left = distributed(csr_array(root), columns, comm)
        right = left.transpose(PETSc.Mat())
        destroy(left)
        return right, right.copy(), identity(right.getLocalSize()[0], comm)


def low_rank_sum(parts: Sequence[tuple[float, LowRank]], rows: int) -> LowRank | None:
    """B B^T, B of so many rows, equal to a sum of factors, none below zero, times pieces.

    None where all are zero.
    """
    columns = []
    for factor, piece in parts:
        own = factor * piece.weights > 0
        columns.append(np.zeros((rows, int(own.sum()))))
        columns[-1][piece.rows] = piece.vectors[:, own] * np.sqrt(factor * piece.weights[own])
    root = np.asfortranarray(np.hstack([np.zeros((rows, 0)), *columns]))
    return LowRank(root, np.ones(root.shape[1])) if root.shape[1] else None


@dataclass(frozen=True)
class Circulatory:
    """L N^-1 J on the displacements, PETSc AIJ (n x m, m x m, m x n), N positive definite."""

    left: Mat
    middle: Mat
    right: Mat

    def times(self, x: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """It, or J^T N^-1 L^T, times a block of vectors, the rows of this rank."""
        if transposed:
            image = self._factors.solve_block(transposed_times(self.left, x))
            return transposed_times(self.right, image)
        return times(self.left, self.inner(x))

    def inner(self, x: NDArray[Any]) -> NDArray[Any]:
        """N^-1 J times a block of vectors, the rows of this rank."""
        return self._factors.solve_block(times(self.right, x))

    def unknowns(self, factor: float) -> Unknowns:
        """Those of a factor times it: L and J share the factor so that both are of one size."""
        left, right = (float(np.max(matrix.norm())) for matrix in (self.left, self.right))
        of_right = np.sqrt(factor * (left / right if left and right else 1.0))
        reaction = self.left.transpose(PETSc.Mat())
        reaction.scale(factor / of_right)
        return scaled_total([(of_right, self.right)]), reaction, self.middle.copy()

    @cached_property
    def _factors(self) -> Mumps:
        return Mumps(self.middle.copy(), symmetric=True)
