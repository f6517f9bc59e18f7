"""Orthonormal bases that grow by blocks, their rows distributed."""

import numpy as np

from cea.arrays import Floats
from cea.reduced.norm import InnerProduct

_RESOLVED = 1e-6
"""Part of the largest direction down to which a Gram matrix tells directions apart."""
_PASSES = 6
"""Most directions of a block are resolved in passes, each to that part of what was left."""

_ROUNDING = 0.5
"""Length that is left of a new vector, orthogonalised once more, up to which it was rounding."""


class Span:
    """An orthonormal basis of the span of all blocks it was given."""

    def __init__(self, norm: InnerProduct) -> None:
        self.norm = norm
        self._store = np.empty((norm.rows, 0), order="F")
        self.size = 0

    @property
    def vectors(self) -> Floats:
        """The basis, the rows of this rank, shape (n_local, size)."""
        return self._store[:, : self.size]

    def add(self, block: Floats, image: Floats, floor: float) -> tuple[Floats, float]:
        """Take the span of a block in, whose image is known, but for vectors of a length.

        Coordinates of the block in the basis are given, and the norm of what was left out of it,
        as an operator on unit coefficients.
        """
        left, products = self._outside(block, image)
        lost = 0.0
        for _ in range(_PASSES):
            sizes, axes = np.linalg.eigh(products)
            largest = float(np.sqrt(max(sizes.max(initial=0.0), 0.0)))
            if largest <= floor:
                break
            kept = sizes > max(_RESOLVED * largest, floor) ** 2
            if not self._append(left @ (axes[:, kept] / np.sqrt(sizes[kept]))):
                lost = max(lost, largest)
            left = left @ axes[:, ~kept]
            left, products = self._outside(left, self.norm.image(left))
        return self.norm.inner(self.vectors, image), max(lost, largest if left.size else 0.0)

    def _outside(self, block: Floats, image: Floats) -> tuple[Floats, Floats]:
        """A block less its part in the span, and the Gram matrix of what is left."""
        left = block - self.vectors @ self.norm.inner(self.vectors, image)
        products = self.norm.inner(left, self.norm.image(left))
        return left, 0.5 * (products + products.T)

    def _append(self, block: Floats) -> bool:
        """New vectors, made orthonormal once more; whether none of them was rounding alone."""
        left, products = self._outside(block, self.norm.image(block))
        sizes, axes = np.linalg.eigh(products)
        kept = sizes > _ROUNDING**2
        size = self.size + int(kept.sum())
        if size > self._store.shape[1]:
            store = np.empty((self.norm.rows, max(size, 3 * self._store.shape[1] // 2)), order="F")
            store[:, : self.size] = self.vectors
            self._store = store
        self._store[:, self.size : size] = left @ (axes[:, kept] / np.sqrt(sizes[kept]))
        self.size = size
        return bool(kept.all())
