"""Circulatory pieces of a stiffness, L N^-1 J: full matrices that are never formed.

Damping that rotates with its body makes one of them of displacements at rest in space
(:mod:`cea.rotation`). They are skew but for what a mesh makes of them.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.blocks import times, transposed_times
from cea.eigen.mumps import Mumps
from cea.eigen.parameters import CONSTANT, Dependence
from cea.matrices import absolute, destroy
from cea.petsc import Mat


@dataclass(frozen=True)
class Circulatory:
    """L N^-1 J on the displacements.

    Parameters
    ----------
    left
        L, PETSc AIJ (n x m).
    middle
        N, PETSc AIJ (m x m), symmetric positive definite.
    right
        J, PETSc AIJ (m x n).
    """

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
