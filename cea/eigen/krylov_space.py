"""The space of a block Krylov method on SLEPc's BV: orthonormal vectors, an operator on them.

A block is projected twice: where friction acts, what an operator makes of it lies in all vectors.
"""

from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.block_products import beside, combined
from cea.eigen.shift_invert import ShiftInvert
from cea.eigen.subspace import symmetric_part
from cea.matrices import dense, destroy
from cea.petsc import PETSc, SLEPc

_NOISE = 1e-12
"""Part of a vector that projections leave below which it lies in the space already."""
_LEFT = 0.3
"""Part of a direction that a further projection leaves below which it was rounding."""
_PROJECTIONS = 3
"""Most projections: the third for what the first leaves of small vectors, far from orthogonal."""
_FIRST, _GROWTH = 128, 1.3
"""Least room for vectors, and its growth where it becomes too small."""
_ORTHONORMAL = 1e-12
"""Distance of inner products from those of orthonormal vectors that is good enough."""


class KrylovSpace:
    """Vectors behind one another: locked ones Q, those of V, and a block U, the next.

    They are orthonormal, at most so many as there is ``room`` for beside Q, and hold
    OP V = Q C + [V U] H.

    Attributes
    ----------
    size, next
        Vectors of V, and of U.
    operator, coupling
        H and C.
    """

    def __init__(self, op: ShiftInvert, locked: Floats, room: int) -> None:
        self._op, self._room = op, room
        self._locked = locked.shape[1]
        self.size = self.next = 0
        self._basis = self._vectors(self._locked + _FIRST)
        self._put(0, locked)
        self._image: Floats = np.empty((op.local, 0))  # of U
        self.operator: Floats = np.empty((0, 0))
        self.coupling: Floats = np.empty((self._locked, 0))

    def close(self) -> None:
        """Free the vectors."""
        destroy(self._basis)

    @property
    def square(self) -> Floats:
        """The rows of H that are those of V, symmetric where OP is."""
        square = self.operator[: self.size]
        return symmetric_part(square) if self._op.symmetric else square

    def start(self, block: Floats) -> None:
        """Begin with a block; V is empty."""
        self._append(block)

    def extend(self) -> None:
        """Take U into V, and OP U beside them as the next U."""
        size, columns = self.size, self.next
        first = self._locked + size
        product = self._op.apply(self._take(first, first + columns), self._image)
        self.size += columns
        coefficients = self._append(np.asfortranarray(product))
        whole: Floats = np.zeros((self.size + self.next, self.size))
        whole[: len(self.operator), :size] = self.operator
        whole[:, size:] = coefficients[self._locked :]
        self.operator = whole
        self.coupling = np.hstack([self.coupling, coefficients[: self._locked]])

    def append_random(self, block: Floats) -> None:
        """Take what of random vectors, overwritten, lies outside of the space into U: H has zeros.

        The block is in Fortran order, the rows of this rank.
        """
        image, columns = self._image, self.next
        self.size += columns
        self._append(block)
        self._image = beside(image, self._image)
        self.size -= columns
        self.operator = np.pad(self.operator, ((0, self.next), (0, 0)))
        self.next += columns

    def combined(self, coefficients: Floats) -> Floats:
        """V times columns."""
        return combined(self._take(self._locked, self._locked + len(coefficients)), coefficients)

    def restart(self, form: Floats, vectors: Floats) -> None:
        """Keep U and an invariant subspace of the square: its Schur form and Schur vectors."""
        first = self._locked + self.size
        block = self._take(first, first + self.next).copy(order="F")
        rest = self.operator[self.size :] @ vectors
        self.size = len(form)
        end = self._locked + self.size
        turn = np.pad(vectors, ((self._locked, 0), (self._locked, 0)))
        self._basis.setActiveColumns(self._locked, first)
        coefficients = dense(turn, (len(turn), len(turn)), PETSc.COMM_SELF)
        self._basis.multInPlace(coefficients, self._locked, end)
        destroy(coefficients)
        self._put(end, block)
        self.operator = np.vstack([form, rest])
        self.coupling = self.coupling @ vectors

    def _vectors(self, columns: int) -> Any:
        """A BV of so many columns."""
        vectors = SLEPc.BV().create(self._op.comm)
        vectors.setSizes((self._op.local, self._op.rows), columns)
        vectors.setType(SLEPc.BV.Type.MAT)
        return vectors

    def _rows(self, vectors: Any) -> Floats:
        """The rows of this rank of a BV, whose array claims to have those of all ranks."""
        return np.asarray(vectors.getArray())[: self._op.local]

    def _take(self, start: int, stop: int) -> Floats:
        """Columns where they are: they must not be held while more are put behind."""
        self._basis.setActiveColumns(0, self._basis.getSizes()[1])
        return self._rows(self._basis)[:, start:stop]

    def _put(self, start: int, block: Floats) -> None:
        """Write columns from a place on; behind the last there is room for more."""
        stop, room = start + block.shape[1], self._basis.getSizes()[1]
        if stop > room:
            larger = self._basis.duplicateResize(max(stop, int(_GROWTH * room)))
            self._basis.setActiveColumns(0, start)
            self._basis.copy(larger)
            destroy(self._basis)
            self._basis = larger
        self._take(start, stop)[:] = block

    def _project(self, block: Floats, image: Floats, stop: int) -> Floats:
        """Coefficients of a block on the first vectors, given its image; they are subtracted."""
        self._basis.setActiveColumns(0, stop)
        vectors = self._vectors(block.shape[1])
        values = self._rows(vectors)
        values[:] = image
        coefficients = vectors.dot(self._basis)
        values[:] = block
        vectors.mult(-1.0, 1.0, self._basis, coefficients)
        block[:] = values
        part = coefficients.getDenseArray().copy()
        destroy(coefficients, vectors)
        return part

    def _append(self, w: Floats) -> Floats:
        """Put the part of a block outside Q and V behind them: w = [Q V U] c, which is returned.

        Columns of w, which is overwritten, that lie in Q and V but for rounding leave none of U.
        """
        op, first = self._op, self._locked + self.size
        most = self._room - self.size  # more directions there are not, but of rounding
        inside: Floats = np.zeros((first, w.shape[1]))
        u, image, rest = w, op.image(w), np.eye(w.shape[1])
        whole: Floats = np.empty(0)
        for again in range(_PROJECTIONS):
            part = self._project(u, image, first)
            inside += part @ rest
            image = op.image(u)
            gram = op.inner(u, image)
            if again and np.abs(gram - np.eye(len(gram))).max(initial=0.0) < _ORTHONORMAL:
                break
            if not again:  # what was projected is orthogonal to what is left
                whole = _lengths(gram, inside)
            sizes = _lengths(gram, part)
            axes = np.linalg.eigh(gram / np.outer(sizes, sizes))[1]
            turn = axes / sizes[:, None]
            u, image = combined(u, turn), combined(image, turn)
            # Of small vectors beside large ones the lengths say more than the eigenvalues.
            lengths = _lengths(op.inner(u, image))
            rest = lengths[:, None] * (axes.T @ (sizes[:, None] * rest))
            # What a second projection takes most of was rounding.
            parts = lengths / _LEFT if again else np.linalg.norm(rest / whole, axis=1) / _NOISE
            kept = np.flatnonzero(parts > 1.0)
            kept = kept[max(0, len(kept) - most) :]
            if len(kept) < len(lengths):
                u, image = (np.asfortranarray(each[:, kept]) for each in (u, image))
            u /= lengths[kept]
            image /= lengths[kept]
            rest = rest[kept]
            if not len(kept):
                break
        self._image = image
        self.next = u.shape[1]
        self._put(first, u)
        return np.vstack([inside, rest])


def _lengths(gram: Floats, projected: Floats | None = None) -> Floats:
    """Lengths of columns of these inner products, none zero, before parts were projected out."""
    squares = np.einsum("ii->i", gram)
    if projected is not None:
        squares = squares + np.linalg.norm(projected, axis=0) ** 2
    return np.sqrt(np.maximum(squares, np.finfo(float).tiny))
