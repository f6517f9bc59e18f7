"""Krylov space of a block method on SLEPc's BV: orthonormal vectors and the projected operator.

Each block is orthogonalised twice, against all vectors: with friction there is no short recurrence.
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
"""Norm of a vector after orthogonalisation, relative to before, below which it is dropped."""
_LEFT = 0.3
"""The same after a further orthogonalisation, below which the vector consists of rounding."""
_PROJECTIONS = 3
"""Largest number of orthogonalisations; the third is for small vectors, which the first leaves far
from orthogonal."""
_FIRST, _GROWTH = 128, 1.3
"""Initial number of columns beyond the locked ones, and factor by which storage is enlarged."""
_ORTHONORMAL = 1e-12
"""Largest deviation of the Gram matrix of orthonormal vectors from the identity."""


class KrylovSpace:
    """Orthonormal vectors [Q V U]: locked ones Q, the basis V, and the next block U.

    They satisfy OP V = Q C + [V U] H; V and U together have at most ``room`` columns.

    Attributes
    ----------
    size, next
        Numbers of columns of V and U.
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
        """Rows of H that belong to V, symmetrised where OP is symmetric."""
        square = self.operator[: self.size]
        return symmetric_part(square) if self._op.symmetric else square

    def start(self, block: Floats) -> None:
        """Set the first block U; V is empty."""
        self._append(block)

    def extend(self) -> None:
        """Append U to V, and make the part of OP U orthogonal to [Q V] the next U."""
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
        """Orthogonalise random vectors against the space and append them to U; H gets zero rows.

        The block holds the rows of this rank in Fortran order, and is overwritten.
        """
        image, columns = self._image, self.next
        self.size += columns
        self._append(block)
        self._image = beside(image, self._image)
        self.size -= columns
        self.operator = np.pad(self.operator, ((0, self.next), (0, 0)))
        self.next += columns

    def combined(self, coefficients: Floats) -> Floats:
        """Return V times the coefficients."""
        return combined(self._take(self._locked, self._locked + len(coefficients)), coefficients)

    def restart(self, form: Floats, vectors: Floats) -> None:
        """Restart with U and an invariant subspace of H, given by Schur form and Schur vectors."""
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
        """Return a BV with the given number of columns."""
        vectors = SLEPc.BV().create(self._op.comm)
        vectors.setSizes((self._op.local, self._op.rows), columns)
        vectors.setType(SLEPc.BV.Type.MAT)
        return vectors

    def _rows(self, vectors: Any) -> Floats:
        """Return the rows of this rank of a BV; the shape of its array names those of all ranks."""
        return np.asarray(vectors.getArray())[: self._op.local]

    def _take(self, start: int, stop: int) -> Floats:
        """Return a view of columns; it becomes invalid when columns are appended."""
        self._basis.setActiveColumns(0, self._basis.getSizes()[1])
        return self._rows(self._basis)[:, start:stop]

    def _put(self, start: int, block: Floats) -> None:
        """Write a block at the columns from ``start``, and enlarge the storage where needed."""
        stop, room = start + block.shape[1], self._basis.getSizes()[1]
        if stop > room:
            larger = self._basis.duplicateResize(max(stop, int(_GROWTH * room)))
            self._basis.setActiveColumns(0, start)
            self._basis.copy(larger)
            destroy(self._basis)
            self._basis = larger
        self._take(start, stop)[:] = block

    def _project(self, block: Floats, image: Floats, stop: int) -> Floats:
        """Subtract from a block its projection on the first vectors; return the coefficients.

        ``image`` is the block times the matrix of the inner product.
        """
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
        """Orthogonalise a block w against [Q V] to obtain U; return c of w = [Q V U] c.

        w is overwritten. Its columns that lie in the span of [Q V] up to rounding are dropped.
        """
        op, first = self._op, self._locked + self.size
        most = self._room - self.size  # dimension of the space left
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
            if not again:  # the projection is orthogonal to the rest: squared norms add
                whole = _lengths(gram, inside)
            sizes = _lengths(gram, part)
            axes = np.linalg.eigh(gram / np.outer(sizes, sizes))[1]
            turn = axes / sizes[:, None]
            u, image = combined(u, turn), combined(image, turn)
            # Norms of small vectors are more accurate than eigenvalues of the Gram matrix.
            lengths = _lengths(op.inner(u, image))
            rest = lengths[:, None] * (axes.T @ (sizes[:, None] * rest))
            # A vector that a second projection reduces strongly consists of rounding.
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
    """Return norms of columns from their Gram matrix, before projected parts were subtracted.

    They are at least the smallest positive number.
    """
    squares = np.einsum("ii->i", gram)
    if projected is not None:
        squares = squares + np.linalg.norm(projected, axis=0) ** 2
    return np.sqrt(np.maximum(squares, np.finfo(float).tiny))
