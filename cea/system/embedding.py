"""Matrices of one body as matrices of the unknowns of all bodies.

On every rank the unknowns are the free dofs of the first body, then those of the second, and so on.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.matrices import block_diagonal, destroy, distributed, one_below_the_other, zeros
from cea.petsc import Mat, PETSc
from cea.ranks import local_rows

type Size = tuple[int, int]
"""Rows or columns of this rank and of all ranks."""


@dataclass(frozen=True)
class Embedding:
    """The unknowns of one body among those of all.

    Parameters
    ----------
    sizes
        Unknowns of this rank and of all ranks, of each body in their order.
    number
        Which of them the body is.
    comm
        Communicator (petsc4py).
    """

    sizes: tuple[Size, ...]
    number: int
    comm: Any

    @property
    def first(self) -> int:
        """Number of its first unknown among those of this rank."""
        return sum(local for local, _ in self.sizes[: self.number])

    def rows(self, matrix: Mat) -> Mat:
        """A matrix of the body as one whose columns are all unknowns; itself without others."""
        own: Any = matrix.getSizes()[0]
        return self._joined(matrix, lambda size: (own, size), lambda blocks: _nest([blocks]))

    def columns(self, matrix: Mat) -> Mat:
        """A matrix of the body as one whose rows are all unknowns; itself without other bodies."""
        own: Any = matrix.getSizes()[1]
        return self._joined(matrix, lambda size: (size, own), one_below_the_other)

    def square(self, matrix: Mat) -> Mat:
        """A matrix of the body as one of all unknowns; itself where there is no other body."""
        return self._joined(
            matrix,
            lambda size: (size, size),
            lambda blocks: block_diagonal(blocks).convert("aij"),
        )

    def _joined(
        self,
        matrix: Mat,
        shape: Callable[[Size], tuple[Size, Size]],
        join: Callable[[list[Mat]], Mat],
    ) -> Mat:
        """A matrix of the body in its place among zeros of the other bodies."""
        if len(self.sizes) == 1:
            return matrix
        blocks = [
            matrix if number == self.number else zeros(*shape(size), self.comm)
            for number, size in enumerate(self.sizes)
        ]
        whole = join(blocks)
        destroy(*(block for block in blocks if block is not matrix))
        return whole

    def upright(self, columns: Floats) -> Mat:
        """Columns of the body, the rows of this rank, as a matrix whose rows are all unknowns."""
        count = columns.shape[1]
        start, stop = local_rows(count, self.comm.tompi4py())
        every = np.zeros((sum(local for local, _ in self.sizes), count))
        every[self.first : self.first + len(columns)] = columns
        return distributed(csr_array(every), (stop - start, count), self.comm)


def _nest(blocks: list[list[Mat]]) -> Mat:
    return PETSc.Mat().createNest(blocks).convert("aij")
