"""X-orthonormal bases that grow by blocks, their rows distributed."""

import numpy as np

from cea.arrays import Floats
from cea.reduced.norm import InnerProduct

_RESOLVED = 1e-6
"""Part of the largest direction down to which a Gram matrix tells directions apart."""
_PASSES = 6
"""Most directions of a block are resolved in passes, each to that part of what was left."""


class Span:
    """An X-orthonormal basis of the span of all blocks it was given.

    A part of a block is left out: ``tolerance``, relative to its longest vector.
    """

    def __init__(self, norm: InnerProduct, tolerance: float) -> None:
        self.norm, self.tolerance = norm, tolerance
        self._store = np.empty((norm.rows, 0), order="F")
        self.size = 0

    @property
    def vectors(self) -> Floats:
        """The basis, the rows of this rank, shape (n_local, size)."""
        return self._store[:, : self.size]

    def add(
        self, block: Floats, image: Floats | None = None, allowed: float = 0.0
    ) -> tuple[Floats, float]:
        """Take the span of a block in, whose image X times it may be known.

        Products with X and with the basis cost more than all else, so there are few: of what is
        left of the block in each pass, and of the vectors that are new. The first pass leaves the
        part in the span that rounding puts back to the new vectors: it is small beside directions
        that are resolved. Vectors shorter than ``allowed`` may be left out. Coordinates of the
        block in the basis are given, and the norm of what was left out of it, as an operator on
        unit coefficients.
        """
        image = self.norm.image(block) if image is None else image
        longest = float(self.norm.lengths(block, image).max(initial=0.0))
        floor = max(self.tolerance * longest, allowed)
        before, known = self.size, self.norm.inner(self.vectors, image)
        left, size = block - self.vectors @ known, np.inf
        sizes, axes = self.norm.principal(self.norm.inner(left, self.norm.image(left)), floor)
        kept = sizes > max(floor, _RESOLVED * longest) ** 2
        self._append(left @ (axes[:, kept] / np.sqrt(sizes[kept])))
        left = left @ axes[:, ~kept]
        for _ in range(_PASSES):
            left, products = self._outside(left)
            sizes, axes = self.norm.principal(products, floor)
            size = float(np.sqrt(max(sizes[-1], 0.0))) if len(sizes) else 0.0
            if size <= floor:
                break
            kept = sizes > max(_RESOLVED * size, floor) ** 2
            self._append(left @ (axes[:, kept] / np.sqrt(sizes[kept])))
            left = left @ axes[:, ~kept]
            if not left.shape[1]:
                size = np.finfo(float).eps * longest
                break
        fresh = self.norm.inner(self.vectors[:, before:], image)
        return np.vstack([known, fresh]), size

    def _outside(self, block: Floats) -> tuple[Floats, Floats]:
        """A block less its part in the span, and W^T X W of what is left.

        The part in the span is X-orthogonal to what is left, so that X times the latter is not
        needed.
        """
        image = self.norm.image(block)
        left = self.norm.held(block - self.vectors @ self.norm.inner(self.vectors, image))
        return left, self.norm.inner(left, image)

    def _append(self, block: Floats) -> None:
        """New vectors, made orthonormal once more: those just resolved are so to few digits."""
        left, products = self._outside(block)
        sizes, axes = self.norm.principal(products)
        self._grow(left @ (axes / np.sqrt(sizes)))

    def _grow(self, block: Floats) -> None:
        size = self.size + block.shape[1]
        if size > self._store.shape[1]:
            store = np.empty((self.norm.rows, max(size, 3 * self._store.shape[1] // 2)), order="F")
            store[:, : self.size] = self.vectors
            self._store = store
        self._store[:, self.size : size] = block
        self.size = size
