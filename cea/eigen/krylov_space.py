"""The space of a block Krylov method: orthonormal vectors, and an operator on them.

A block is projected twice: where friction acts, what an operator makes of it lies in all vectors.
"""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.columns import Columns
from cea.eigen.dense_products import beside, combined, subtract

_NOISE = 1e-12
"""Part of a vector that projections leave below which it lies in the space already."""
_LEADING = 16
"""First vectors whose images are kept."""
_LEFT = 0.3
"""Part of a direction that a further projection leaves below which it was rounding."""
_FELL = 0.1
"""Part of each direction that a projection leaves at which no other is needed."""
_MOST_PROJECTIONS = 3
"""The third for what the first leaves of small vectors, far from orthogonal."""
_ORTHONORMAL = 1e-12
"""Distance of inner products from those of orthonormal vectors that is good enough."""


class InnerProduct(Protocol):
    """An inner product and an operator OP on blocks of distributed vectors.

    Attributes
    ----------
    dtype
        Of its vectors, float or complex.
    """

    dtype: type

    def apply(self, block: NDArray[Any], image: NDArray[Any]) -> NDArray[Any]:
        """OP on a block whose image is given, a new block."""
        ...

    def image(self, block: NDArray[Any]) -> NDArray[Any]:
        """A block times the matrix of the inner product, a new block."""
        ...

    def inner(self, left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
        """Inner products of every column of one block with every column of another."""
        ...


class KrylovSpace:
    """Vectors behind one another: those of Q, known before, those of V, and a block U, the next.

    They hold OP V = Q C + [V U] H.

    Parameters
    ----------
    owner
        OP and the inner product in which all vectors are orthonormal.
    known
        Q, the rows of this rank, shape (n_local, k).
    room
        Most vectors of V and U: there are no more directions.

    Attributes
    ----------
    size, next
        Vectors of V, and of U.
    operator, coupling
        H and C.
    """

    def __init__(self, owner: InnerProduct, known: NDArray[Any], room: int) -> None:
        self._owner, self._room = owner, room
        self._known = known.shape[1]
        self.size = self.next = 0
        self._vectors = Columns(known, room, owner.dtype)
        self._images: list[tuple[int, NDArray[Any]]] = []
        self._keep_first()
        self.operator: NDArray[Any] = np.empty((0, 0), dtype=owner.dtype)
        self.coupling: NDArray[Any] = np.empty((self._known, 0), dtype=owner.dtype)

    @property
    def square(self) -> NDArray[Any]:
        """The rows of H that are those of V."""
        return self.operator[: self.size]

    def start(self, block: NDArray[Any]) -> None:
        """Begin with a block; V is empty."""
        self._append(block)

    def extend(self) -> None:
        """Take U into V, and OP U beside them as the next U."""
        size, columns = self.size, self.next
        first = self._known + size
        fresh = self._owner.apply(self._vectors.take(first, first + columns), self._images[-1][1])
        self.size += columns
        coefficients = self._append(np.asfortranarray(fresh))
        shape = (self.size + self.next, self.size)
        whole: NDArray[Any] = np.zeros(shape, dtype=self._owner.dtype)
        whole[: len(self.operator), :size] = self.operator
        whole[:, size:] = coefficients[self._known :]
        self.operator = whole
        self.coupling = np.hstack([self.coupling, coefficients[: self._known]])

    def join(self, block: NDArray[Any]) -> None:
        """Take what of a block lies outside of all vectors into U, beside what is there.

        Parameters
        ----------
        block
            In Fortran order, the rows of this rank; it is overwritten.
        """
        images, columns = self._images, self.next
        self.size += columns
        self._append(block)
        start, image = images[-1]
        self._images = [*images[:-1], (start, beside(image, self._images[-1][1]))]
        self.size -= columns
        self.operator = np.pad(self.operator, ((0, self.next), (0, 0)))
        self.next += columns

    def combined(self, coefficients: NDArray[Any]) -> NDArray[Any]:
        """V times columns."""
        return self._vectors.combined(self._known, coefficients)

    def restart(self, form: NDArray[Any], vectors: NDArray[Any]) -> None:
        """Keep an invariant subspace of the square, and U.

        Parameters
        ----------
        form, vectors
            Its Schur form, and its orthonormal vectors.
        """
        first = self._known + self.size
        block = self._vectors.take(first, first + self.next).copy(order="F")
        kept = self.combined(vectors)
        rest = self.operator[self.size :] @ vectors
        self.size = len(form)
        end = self._known + self.size
        self._vectors.put(self._known, kept)
        self._vectors.put(end, block)
        self.operator = np.vstack([form, rest])
        self._images = [(end, self._images[-1][1])]
        self._keep_first()
        self.coupling = self.coupling @ vectors

    def _append(self, w: NDArray[Any]) -> NDArray[Any]:
        """Put the part of a block outside Q and V behind them: w = [Q V U] c.

        Columns of w that lie in Q and V but for rounding leave no column of U.

        Parameters
        ----------
        w
            The block, in Fortran order; it is overwritten.

        Returns
        -------
        ndarray
            c.
        """
        owner, first = self._owner, self._known + self.size
        most = self._room - self.size  # more directions there are not, but of rounding
        inside: NDArray[Any] = np.zeros((first, w.shape[1]), w.dtype)
        self._take_out_what_is_large(w, inside)
        u, image = w, owner.image(w)
        rest: NDArray[Any] = np.eye(w.shape[1], dtype=w.dtype)
        whole: Floats = np.empty(0)
        for again in range(_MOST_PROJECTIONS):
            part = self._vectors.inner(first, image, owner.inner)
            inside += part @ rest
            self._vectors.subtract(u, part)
            image = owner.image(u)
            gram = owner.inner(u, image)
            if again and np.abs(gram - np.eye(len(gram))).max(initial=0.0) < _ORTHONORMAL:
                break
            if not again:  # what was projected is orthogonal to what is left
                whole = _lengths(gram, inside)
            sizes = _lengths(gram, part)
            axes = np.linalg.eigh(gram / np.outer(sizes, sizes))[1]
            turn = axes / sizes[:, None]
            u, image = combined(u, turn), combined(image, turn)
            # Of small vectors beside large ones the lengths say more than the eigenvalues.
            lengths = _lengths(owner.inner(u, image))
            rest = lengths[:, None] * (axes.conj().T @ (sizes[:, None] * rest))
            # What a second projection takes most of was rounding.
            parts = lengths / _LEFT if again else np.linalg.norm(rest / whole, axis=1) / _NOISE
            kept = np.flatnonzero(parts > 1.0)
            kept = kept[max(0, len(kept) - most) :]
            u, image, rest = _columns(u, kept), _columns(image, kept), rest[kept]
            u /= lengths[kept]
            image /= lengths[kept]
            if not again and lengths[kept].min(initial=1.0) >= _FELL:
                break
        self._keep_images(image, first)
        self.next = u.shape[1]
        self._vectors.put(first, u)
        return np.vstack([inside, rest])

    def _take_out_what_is_large(self, w: NDArray[Any], inside: NDArray[Any]) -> None:
        """Project a block on those whose images are known; add its coefficients.

        OP is selfadjoint but for friction, and what it makes of a block lies in the last two, but
        for that and for rounding. Both are largest along the eigenvectors nearest to the shift,
        which the first vectors hold.
        """
        for start, image in self._images:
            stop = start + image.shape[1]
            part = self._owner.inner(image, w)
            subtract(w, self._vectors.take(start, stop), part)
            inside[start:stop] = part

    def _keep_first(self) -> None:
        """Find the image of the first vectors, if there are any."""
        first = self._vectors.take(0, min(_LEADING, self._known + self.size))
        if first.shape[1]:
            self._images.insert(0, (0, self._owner.image(first)))

    def _keep_images(self, fresh: NDArray[Any], start: int) -> None:
        """Keep the image of a new block, of that before it, and of the first vectors."""
        first = [each for each in self._images[:-1] if each[0] < _LEADING]
        self._images = [*first, *self._images[-1:], (start, fresh)]


def _lengths(gram: NDArray[Any], projected: NDArray[Any] | None = None) -> Floats:
    """Lengths of the columns of a block, of which none is zero.

    Parameters
    ----------
    gram
        Their inner products.
    projected
        Coefficients of what was taken out of them along orthonormal vectors: their lengths before.
    """
    squares = np.einsum("ii->i", gram).real
    if projected is not None:
        squares = squares + np.linalg.norm(projected, axis=0) ** 2
    return np.sqrt(np.maximum(squares, np.finfo(float).tiny))


def _columns(block: NDArray[Any], kept: NDArray[np.int64]) -> NDArray[Any]:
    """Some columns of a block in Fortran order, in that order again."""
    return block if len(kept) == block.shape[1] else np.asfortranarray(block[:, kept])
