"""One search of a block Krylov-Schur method: its space, restarts, and what it locks."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import schur

from cea.arrays import Complexes, Floats
from cea.eigen.subspace import InvariantSubspace, small_eigenpairs, symmetric_part
from cea.errors import ConvergenceError

_BLOCK = 8
"""Columns of a block."""
_LEAST = 6
"""Blocks of a space before it is looked at: an eigenvalue must have had time to show."""
_GROWTH = 1.3
"""Growth of the Krylov space between two looks at its eigenvalues."""
_RESTART = 2.5
"""Size of the space, relative to the eigenvalues wanted of it, at which it is restarted."""
_NOISE = 1e-12
"""Part of a vector that projections leave below which it lies in the space already."""
_ORTHONORMAL = 1e-12
"""Distance of inner products from those of orthonormal vectors that is good enough."""
_PAIR = 1e-9
"""Relative distance of moduli up to which eigenvalues stay together, as conjugate ones must."""
_AROUND = 0.1
"""Part of 1 / radius to which eigenvalues around a disc are kept: those farther lose digits."""
_CLEAR = 3.0
"""Residuals by which an eigenvalue outside a disc must lie outside."""


class CrowdedError(ConvergenceError):
    """More eigenvalues in a disc than are worth their price.

    Parameters
    ----------
    number
        How many its space knows of.
    """

    def __init__(self, number: int) -> None:
        super().__init__(f"a disc holds {number} eigenvalues or more")


class ShiftInvert(Protocol):
    """An operator OP with eigenvalues theta = 1 / (kappa - sigma), and its inner product.

    Attributes
    ----------
    size, finite
        Rows of its vectors on all ranks, and number of its eigenvalues that are not zero.
    shift
        sigma.
    comm
        Communicator (mpi4py).
    dtype
        Of its vectors, float or complex.
    unknown
        What the eigenvalues kappa are called.
    cleansing
        Times that it is applied to take what is infinite out of a vector.
    tolerance
        Residual relative to theta below which an eigenvalue has converged.
    max_restarts
        Restarts before a search is given up.
    most
        Eigenvalues beside the known in a disc at which it is called crowded.
    """

    size: int
    finite: int
    shift: complex
    comm: Any
    dtype: type
    unknown: str
    cleansing: int
    tolerance: float
    max_restarts: int
    most: int

    def apply(self, block: NDArray[Any], image: NDArray[Any]) -> NDArray[Any]:
        """OP on a block whose image is given."""
        ...

    def image(self, block: NDArray[Any]) -> NDArray[Any]:
        """A block times the matrix of the inner product."""
        ...

    def diagonal(self, left: NDArray[Any], right: NDArray[Any]) -> Floats:
        """Inner products of the columns of two blocks, one with one."""
        ...

    def inner(self, left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
        """Inner products of every column of one block with every column of another."""
        ...


class KrylovRun:
    """One search: its Krylov space V, M-orthonormal and beside Q, with OP on it.

    Vectors stand in one array: those of Q, those of V, and a block U that OP is applied to next,

        OP V = Q C + [V U] H.
    """

    def __init__(
        self,
        owner: ShiftInvert,
        known: InvariantSubspace,
        radius: float,
        seed: int,
        *,
        both_ends: bool,
    ) -> None:
        self._owner, self._known = owner, known
        self._least = 1.0 / radius
        self._both_ends = both_ends
        self.farthest = np.inf
        self._shift = owner.shift
        self._room = owner.size - known.size
        self._finite = owner.finite - known.size
        room = (len(known.basis), known.size + 8 * _BLOCK)
        self._vectors: NDArray[Any] = np.empty(room, dtype=owner.dtype, order="F")
        self._vectors[:, : known.size] = known.basis
        self._size = self._next = 0
        self._coupling, self._operator = np.empty((known.size, 0)), np.empty((0, 0))
        if self._finite > 0:
            columns = min(_BLOCK, self._room)
            random = np.random.default_rng([seed, owner.comm.rank])
            size = (len(known.basis), columns)
            start: NDArray[Any] = random.standard_normal(size).astype(owner.dtype)
            if owner.dtype is complex:
                start += 1j * random.standard_normal(size)
            # OP takes what is far away out of a vector, ties above all.
            far = both_ends and owner.finite == owner.size
            for _ in range(0 if far else owner.cleansing):
                start = owner.apply(start, owner.image(start))
            self._append(start)

    def complete(self) -> InvariantSubspace:
        """The known with all that is in the disc."""
        restarts, look = 0, _LEAST * _BLOCK
        while self._finite > 0:
            exhausted = not self._next or self._size >= self._room
            if self._size < look and not exhausted:
                self._extend()
                continue
            theta, residuals = self._ritz()
            inside = np.abs(theta) >= self._least
            near = inside if self._both_ends else np.abs(theta) >= _AROUND * self._least
            converged = residuals <= self._owner.tolerance * np.abs(theta)
            if exhausted:  # ties have infinite eigenvalues, theta = 0 but for rounding
                converged = self._largest(theta)
                self.farthest = self._far_end(theta[converged], 0 * residuals[converged])
                return self._locked(theta, converged & near)
            if converged[inside].all() and self._clear(theta, residuals, inside):
                self.farthest = self._far_end(theta, residuals)
                return self._locked(theta, converged & near)
            wanted = int(inside.sum())
            if wanted > self._owner.most:
                raise CrowdedError(wanted)
            if self._size >= max(12 * _BLOCK, _RESTART * wanted + 6 * _BLOCK):
                if restarts == self._owner.max_restarts:
                    where = f"{self._owner.unknown} = {self._shift:.4g}"
                    raise ConvergenceError(
                        f"{int((inside & ~converged).sum())} eigenvalues in the disc of radius "
                        f"{1 / self._least:.4g} about {where} did not converge",
                        best=self._locked(theta, converged),
                    )
                restarts += 1
                self._restart(theta, wanted + 3 * _BLOCK)
            look = max(self._size + _BLOCK, int(_GROWTH * self._size))
        return self._known

    def _extend(self) -> None:
        """Take U into V, and OP U beside them as the next U."""
        size, columns = self._size, self._next
        first = self._known.size + size
        block = self._vectors[:, first : first + columns]
        fresh = self._owner.apply(block, self._image)
        self._size += columns
        coefficients = self._append(fresh)
        known = self._known.size
        shape = (self._size + self._next, self._size)
        whole: NDArray[Any] = np.zeros(shape, dtype=self._owner.dtype)
        whole[: len(self._operator), :size] = self._operator
        whole[:, size:] = coefficients[known:]
        self._operator = whole
        self._coupling = np.hstack([self._coupling, coefficients[:known]])

    def _append(self, w: NDArray[Any]) -> NDArray[Any]:
        """Put the part of a block outside Q and V behind them: w = [Q V U] c.

        Columns of w that lie in Q and V but for rounding leave no column of U.

        Returns
        -------
        ndarray
            c.
        """
        owner, first = self._owner, self._known.size + self._size
        before = self._vectors[:, :first]
        most = self._room - self._size  # more directions there are not, but of rounding
        image = owner.image(w)
        squares = owner.diagonal(w, image)
        lengths = np.sqrt(np.maximum(squares, np.finfo(float).tiny))
        u, image = w / lengths, image / lengths
        inside, rest, least = np.zeros((first, w.shape[1]), w.dtype), np.diag(lengths), _NOISE
        for _ in range(3):  # a third time, for the first leaves small vectors far from orthogonal
            part = owner.inner(before, image)
            inside += part @ rest
            u -= before @ part
            image = owner.image(u)
            gram = owner.inner(u, image)
            if np.abs(gram - np.eye(len(gram))).max(initial=0.0) < _ORTHONORMAL:
                break
            axes = np.linalg.eigh(gram)[1]
            u, image = u @ axes, image @ axes
            # Of small vectors beside large ones the lengths say more than the eigenvalues.
            lengths = np.sqrt(np.maximum(owner.diagonal(u, image), 0.0))
            kept = np.flatnonzero(lengths > least)
            kept = kept[max(0, len(kept) - most) :]
            u, image = u[:, kept] / lengths[kept], image[:, kept] / lengths[kept]
            rest = (axes[:, kept] * lengths[kept]).conj().T @ rest
            least = 0.3  # what a second projection takes most of was rounding
        self._next, self._image = u.shape[1], image
        if first + self._next > self._vectors.shape[1]:
            wider = np.empty((len(u), int(1.5 * first) + _BLOCK), dtype=u.dtype, order="F")
            wider[:, :first] = before
            self._vectors = wider
        self._vectors[:, first : first + self._next] = u
        return np.vstack([inside, rest])

    def _square(self) -> NDArray[Any]:
        square = self._operator[: self._size]
        return symmetric_part(square) if self._known.symmetric else square

    def _space(self, vectors: NDArray[Any]) -> NDArray[Any]:
        """V times columns."""
        known = self._known.size
        return self._vectors[:, known : known + self._size] @ vectors

    def _ritz(self) -> tuple[Complexes, Floats]:
        """Eigenvalues of OP on the space and the residuals of their vectors."""
        theta, vectors = small_eigenpairs(self._square(), symmetric=self._known.symmetric)
        rest = self._operator[self._size :]
        return theta, np.linalg.norm(rest @ vectors, axis=0)

    def _clear(self, theta: Complexes, residuals: Floats, inside: NDArray[np.bool_]) -> bool:
        """Whether the first eigenvalue outside has converged enough to be outside."""
        if inside.all():
            return False
        sizes = np.where(inside, 0.0, np.abs(theta))
        first = int(np.argmax(sizes))
        return bool(_CLEAR * residuals[first] <= self._least - sizes[first])

    def _far_end(self, theta: Complexes, residuals: Floats) -> float:
        """Largest abs(kappa), by kappa / (kappa - sigma) = 1 + sigma theta.

        As theta itself for eigenvalues near the shift, this is largest for those far from it, and
        the same space finds both ends.
        """
        parts = np.abs(1 + self._shift * theta) + _CLEAR * np.abs(self._shift) * residuals
        part = float(parts.max(initial=0.0))
        return part / (1 - part) * abs(self._shift) if part < 1 else np.inf

    def _leading(self, theta: Complexes, number: int) -> tuple[NDArray[Any], NDArray[Any]]:
        """Schur form of OP on so many eigenvalues of largest modulus; no pair is split."""
        sizes = np.sort(np.abs(theta))[::-1]
        while 0 < number < len(sizes) and sizes[number] > (1 - _PAIR) * sizes[number - 1]:
            number += 1
        output: Any = "complex" if self._owner.dtype is complex else "real"
        if number >= len(sizes):
            form, vectors = schur(self._square(), output=output)
            return form, vectors
        cut = 0.5 * (sizes[number - 1] + sizes[number])
        form, vectors, kept = schur(
            self._square(),
            output=output,
            sort=lambda value, im=0.0: bool(np.abs(value + 1j * im) >= cut),
        )
        return form[:kept, :kept], vectors[:, :kept]

    def _restart(self, theta: Complexes, number: int) -> None:
        """Keep the leading eigenvalues, and U."""
        form, vectors = self._leading(theta, number)
        known, size = self._known.size, self._size
        block = self._vectors[:, known + size : known + size + self._next].copy()
        kept = self._space(vectors)
        rest = self._operator[size:] @ vectors
        self._size = len(form)
        end = known + self._size
        self._vectors[:, known:end] = kept
        self._vectors[:, end : end + self._next] = block
        self._operator = np.vstack([form, rest])
        self._coupling = self._coupling @ vectors

    def _largest(self, theta: Complexes) -> NDArray[np.bool_]:
        """So many eigenvalues as are finite."""
        chosen = np.zeros(len(theta), dtype=bool)
        chosen[np.argsort(-np.abs(theta))[: self._finite]] = True
        return chosen

    def _locked(self, theta: Complexes, converged: NDArray[np.bool_]) -> InvariantSubspace:
        """The known with the leading eigenvalues, as far as they have converged."""
        order = np.argsort(-np.abs(theta))
        number = len(order) if converged.all() else int(np.argmin(converged[order]))
        if 0 < number < len(order):
            last, beyond = theta[order[number - 1]], theta[order[number]]
            number -= int(last.imag != 0 and np.isclose(last.conj(), beyond, rtol=_PAIR, atol=0.0))
        if not number:
            return self._known
        form, vectors = self._leading(theta, number)
        coupling = self._coupling @ vectors
        return self._known.extended(self._space(vectors), coupling, form, self._shift)
