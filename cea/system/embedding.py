"""Matrices of one body as matrices of the unknowns of all bodies.

On every rank the unknowns are the free dofs of the first body, then those of the second, and so on.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.matrices import block_diagonal, destroy, distributed, one_below_the_other, zeros
from cea.petsc import Mat, PETSc
from cea.ranks import local_rows


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

    sizes: tuple[tuple[int, int], ...]
    number: int
    comm: Any

    @property
    def first(self) -> int:
        """Number of its first unknown among those of this rank."""
        return sum(local for local, _ in self.sizes[: self.number])

    def rows(self, matrix: Mat) -> Mat:
        """A matrix of the body as one whose columns are all unknowns; itself without others."""
        if len(self.sizes) == 1:
            return matrix
        own: Any = matrix.getSizes()[0]
        blocks = [
            matrix if number == self.number else zeros(own, size, self.comm)
            for number, size in enumerate(self.sizes)
        ]
        whole = PETSc.Mat().createNest([blocks]).convert("aij")
        destroy(*(block for block in blocks if block is not matrix))
        return whole

    def columns(self, matrix: Mat) -> Mat:
        """A matrix of the body as one whose rows are all unknowns; itself without other bodies."""
        if len(self.sizes) == 1:
            return matrix
        own: Any = matrix.getSizes()[1]
        blocks = [
            matrix if number == self.number else zeros(size, own, self.comm)
            for number, size in enumerate(self.sizes)
        ]
        whole = one_below_the_other(blocks)
        destroy(*(block for block in blocks if block is not matrix))
        return whole

    def square(self, matrix: Mat) -> Mat:
        """A matrix of the body as one of all unknowns; itself where there is no other body."""
        if len(self.sizes) == 1:
            return matrix
        blocks = [
            matrix if number == self.number else zeros(size, size, self.comm)
            for number, size in enumerate(self.sizes)
        ]
        whole = block_diagonal(blocks).convert("aij")
        destroy(*(block for block in blocks if block is not matrix))
        return whole

    def upright(self, columns: Floats) -> Mat:
        """Columns of the body, the rows of this rank, as a matrix whose rows are all unknowns."""
        count = columns.shape[1]
        start, stop = local_rows(count, self.comm.tompi4py())
        every = np.zeros((sum(local for local, _ in self.sizes), count))
        every[self.first : self.first + len(columns)] = columns
        return distributed(csr_array(every), (stop - start, count), self.comm)
