"""Terms of a pencil that are never formed as matrices, since these would be dense.

Low-rank symmetric terms of the damping, W diag(d) W^T, such as modal damping. Circulatory terms of
the stiffness, L N^-1 J, such as damping that rotates with its body, in displacements at points
fixed in space (:mod:`cea.motion`); it is skew up to discretisation errors.
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
"""J, L^T and N, new matrices, of a term L N^-1 J with the unknowns w = N^-1 J x."""


@dataclass(frozen=True)
class UnformedTerm[Piece]:
    """A coefficient c(t) >= 0 times a piece."""

    piece: Piece
    coefficient: Dependence = CONSTANT


@dataclass(frozen=True)
class LowRank:
    """W diag(d) W^T, d >= 0 of shape (r,); ``vectors`` are the rows of W on this rank."""

    vectors: Floats
    weights: Floats

    def times(self, x: NDArray[Any], comm: Any) -> NDArray[Any]:
        """Return W diag(d) W^T times a block of vectors, the rows of this rank."""

        def product(part: Floats) -> Floats:
            inner = comm.tompi4py().allreduce(self.vectors.T @ part)
            return np.asfortranarray(self.vectors @ (self.weights[:, None] * inner))

        return by_parts(product, x)

    def sizes(self, x: Floats, comm: Any) -> Floats:
        """Return abs(W) diag(d) abs(W)^T x, for estimates of rounding."""
        return LowRank(np.abs(self.vectors), self.weights).times(x, comm)

    def unknowns(self, factor: float, comm: Any) -> Unknowns:
        """Return the unknowns of a factor times this term."""
        columns: Any = (PETSc.DECIDE, self.vectors.shape[1])
        root = self.vectors * np.sqrt(factor * self.weights)
        left = distributed(csr_array(root), columns, comm)
        right = left.transpose(PETSc.Mat())
        destroy(left)
        return right, right.copy(), identity(right.getLocalSize()[0], comm)


def low_rank_sum(parts: Sequence[tuple[float, LowRank]], rows: int) -> LowRank | None:
    """Return B B^T, B with the given number of rows, equal to a sum of factors >= 0 times pieces.

    None where all products are zero.
    """
    columns = []
    for factor, piece in parts:
        own = factor * piece.weights > 0
        columns.append(piece.vectors[:, own] * np.sqrt(factor * piece.weights[own]))
    root = np.asfortranarray(np.hstack([np.zeros((rows, 0)), *columns]))
    return LowRank(root, np.ones(root.shape[1])) if root.shape[1] else None


@dataclass(frozen=True)
class Circulatory:
    """L N^-1 J on the displacements, PETSc AIJ (n x m, m x m, m x n), N positive definite."""

    left: Mat
    middle: Mat
    right: Mat

    def times(self, x: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Return L N^-1 J, or its transpose, times a block of vectors, the rows of this rank."""
        if transposed:
            image = self._factors.solve_block(transposed_times(self.left, x))
            return transposed_times(self.right, image)
        return times(self.left, self.inner(x))

    def inner(self, x: NDArray[Any]) -> NDArray[Any]:
        """Return N^-1 J times a block of vectors, the rows of this rank."""
        return self._factors.solve_block(times(self.right, x))

    def unknowns(self, factor: float) -> Unknowns:
        """Return the unknowns of a factor times this term, split to give L and J equal norms."""
        left, right = (float(np.max(matrix.norm())) for matrix in (self.left, self.right))
        of_right = np.sqrt(factor * (left / right if left and right else 1.0))
        reaction = self.left.transpose(PETSc.Mat())
        reaction.scale(factor / of_right)
        return scaled_total([(of_right, self.right)]), reaction, self.middle.copy()

    @cached_property
    def _factors(self) -> Mumps:
        return Mumps(self.middle.copy(), symmetric=True)
