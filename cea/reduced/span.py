"""X-orthonormal bases that grow by blocks, their rows distributed."""

import numpy as np

from cea.arrays import Floats
from cea.reduced.norm import EnergyNorm

_RESOLVED = 1e-6
"""Part of the largest direction down to which a Gram matrix tells directions apart."""
_PASSES = 6
"""Most directions of a block are resolved in passes, each to that part of what was left."""


class Span:
    """An X-orthonormal basis of the span of all blocks it was given.

    Parameters
    ----------
    norm
        X.
    tolerance
        Part of a block, relative to its longest vector, that is left out.

    Attributes
    ----------
    vectors
        The basis, the rows of this rank, shape (n_local, size).
    """

    def __init__(self, norm: EnergyNorm, tolerance: float) -> None:
        self.norm, self.tolerance = norm, tolerance
        self._store = np.empty((norm.rows, 0), order="F")
        self.size = 0

    @property
    def vectors(self) -> Floats:
        """The basis, the rows of this rank, shape (n_local, size)."""
        return self._store[:, : self.size]

    def add(self, block: Floats) -> float:
        """Take the span of a block in.

        Returns
        -------
        float
            Norm of what was left out of the block, as an operator on unit coefficients.
        """
        left, size = block, np.inf
        floor = self.tolerance * float(self.norm.lengths(block).max(initial=0.0))
        for _ in range(_PASSES):
            left = self._outside(self._outside(left))
            image = self.norm.image(left)
            sizes, axes = self.norm.gram(left, image)
            size = float(np.sqrt(max(sizes[-1], 0.0))) if len(sizes) else 0.0
            if size <= floor:
                break
            kept = sizes > max(_RESOLVED * size, floor) ** 2
            self._append(left @ (axes[:, kept] / np.sqrt(sizes[kept])))
        return size

    def coordinates(self, forces: Floats) -> Floats:
        """Q^T A of the images of vectors under an operator, shape (size, columns)."""
        return self.norm.inner(self.vectors, forces)

    def restore(self, vectors: Floats) -> None:
        """Take over vectors that are X-orthonormal to those that are there."""
        self._grow(vectors)

    def _outside(self, block: Floats) -> Floats:
        """A block less its part in the span."""
        if not self.size:
            return block
        return block - self.vectors @ self.norm.inner(self.vectors, self.norm.image(block))

    def _append(self, block: Floats) -> None:
        """New vectors, made orthonormal once more: those just resolved are so to few digits."""
        block = self._outside(block)
        sizes, axes = self.norm.gram(block, self.norm.image(block))
        self._grow(block @ (axes / np.sqrt(sizes)))

    def _grow(self, block: Floats) -> None:
        size = self.size + block.shape[1]
        if size > self._store.shape[1]:
            store = np.empty((self.norm.rows, max(size, 3 * self._store.shape[1] // 2)), order="F")
            store[:, : self.size] = self.vectors
            self._store = store
        self._store[:, self.size : size] = block
        self.size = size
