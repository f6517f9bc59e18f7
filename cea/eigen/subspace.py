"""Invariant subspaces of a pencil: their eigenpairs, and by LAPACK all of a small pencil.

Where few rows are, the inverted operator is applied to the identity and none can be missing:
relative to the shift its eigenvalues near the window are large, and stiff penalties, which are
small in it, leave them their digits. Where entries of the matrix are far apart, LAPACK balances it
by powers of two first. Eigenvectors are then orthogonal in units of their own, and only left
vectors tell the errors.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Self

import numpy as np
from scipy.linalg import LinAlgError, cholesky, matrix_balance, schur, solve_triangular, svd
from scipy.linalg.lapack import dtrsen

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.block_products import beside, column_blocks, combined
from cea.eigen.shift_invert import ShiftInvert

type Radius = Callable[[float, Complexes], float]
"""Radius of the disc about a shift that is searched, from the theta that are known."""

_ROUNDING = 1e-13
"""theta relative to the largest that may be rounding of zero."""
_GRADED = 64.0
"""Ratio of the factors of balancing from which on norms say nothing."""


@dataclass(frozen=True)
class InvariantSubspace:
    """Vectors Q, M-orthonormal, with M^-1 K Q = Q R, R block upper triangular."""

    basis: Floats  # Q, the rows of this rank, shape (n_local, k)
    projected: Floats  # R (1/s^2), shape (k, k)
    symmetric: bool  # whether R is symmetric but for rounding, as without friction
    whole: bool = False  # whether it holds all of the window, as LAPACK tells of small systems
    graded: bool = False  # whether Q is orthonormal in units of its own, and not in M

    @classmethod
    def empty(cls, rows: int, *, symmetric: bool) -> "InvariantSubspace":
        """The subspace of nothing, with so many rows on this rank."""
        return cls(np.empty((rows, 0)), np.empty((0, 0)), symmetric)

    @property
    def size(self) -> int:
        """Number of eigenvalues, with multiplicity."""
        return len(self.projected)

    @property
    def eigenvalues(self) -> Complexes:
        """kappa, shape (k,)."""
        return self._pairs[0]

    def eigenpairs(self, rows: int | None = None) -> tuple[Complexes, Complexes]:
        """Eigenvalues, shape (k,), and the first rows of eigenvectors, shape (rows, k).

        A conjugate follows its eigenvalue, and its vector is the conjugate. Undamped ones rise with
        Im lambda, kappa = -lambda^2.
        """
        values, small = self._pairs
        basis = self.basis[:rows]
        vectors = np.zeros((len(basis), self.size), dtype=complex, order="F")
        if not self.size:
            return values, vectors
        twins = _twins(values)
        own = np.setdiff1d(np.arange(self.size), twins)
        turned = own[small.imag[:, own].any(axis=0)]
        vectors.real[:, own] = combined(basis, small.real[:, own])
        vectors.imag[:, turned] = combined(basis, small.imag[:, turned])
        vectors[:, twins] = vectors[:, twins - 1].conj()
        return values, vectors

    def duals(self) -> Complexes:
        """Dual basis of the eigenvectors in the basis, (k, k); its lengths are conditions."""
        vectors = self._pairs[1]
        if self.symmetric or not self.size:
            return vectors
        left, sizes, right = svd(vectors, lapack_driver="gesvd")
        sizes = np.maximum(sizes, np.sqrt(np.finfo(float).eps) * sizes.max(initial=0.0))
        return np.asarray((left / sizes) @ right)

    @cached_property
    def _pairs(self) -> tuple[Complexes, Complexes]:
        values, vectors = small_eigenpairs(self.projected, symmetric=self.symmetric)
        order = _rising(values)
        return values[order], vectors[:, order]

    def extended(self, basis: Floats, coupling: Floats, form: Floats, shift: float) -> Self:
        """With vectors V beside it: OP [Q V] = [Q V] [(R - shift)^-1, coupling; 0, form]."""
        own = np.linalg.inv(form)
        # What was known stays as it is: far from a shift digits are lost to it.
        across = -(self.projected - shift * np.eye(self.size)) @ coupling @ own
        own = own + shift * np.eye(len(form))
        nothing = np.zeros((len(form), self.size))
        projected = np.block([[self.projected, across], [nothing, own]])
        return type(self)(beside(self.basis, basis), projected, self.symmetric)


def symmetric_part(matrix: Floats) -> Floats:
    """Symmetric part."""
    return 0.5 * (matrix + matrix.T)


def small_eigenpairs(matrix: Floats, *, symmetric: bool) -> tuple[Complexes, Complexes]:
    """Eigenvalues and vectors of a small matrix."""
    values, vectors = np.linalg.eigh(symmetric_part(matrix)) if symmetric else np.linalg.eig(matrix)
    return values.astype(complex), vectors.astype(complex)


def _twins(values: Complexes) -> Ints:
    """Numbers of the conjugates of what precedes them; rounding may leave a lower one alone."""
    return 1 + np.flatnonzero(values.imag > 0)


def _rising(values: Complexes) -> Ints:
    """Order of kappa by Re sqrt(kappa), which is Im lambda; conjugates stay together."""
    twins = _twins(values)
    firsts = np.setdiff1d(np.arange(len(values)), twins)
    firsts = firsts[np.lexsort((-values[firsts].real, np.sqrt(values[firsts]).real))]
    followed = np.isin(firsts + 1, twins)
    pairs = np.stack([firsts, np.where(followed, firsts + 1, -1)], axis=1).ravel()
    return pairs[pairs >= 0]


def dense_subspace(
    op: ShiftInvert, radius: Callable[[Complexes], float], *, disc_only: bool = False
) -> InvariantSubspace:
    """The eigenvalues of a disc about the shift, and unless told all of the window; collective."""
    chosen = partial(_kept, op, radius, disc_only)
    operator, root, rows = _gathered(op)
    if op.symmetric:
        theta, vectors = np.linalg.eigh(symmetric_part(operator))
        kept = chosen(theta.astype(complex))
        form, vectors, factors = np.diag(theta[kept]), vectors[:, kept], np.ones(len(theta))
    else:
        operator, (factors, _) = matrix_balance(operator, permute=False, separate=True)
        if factors.max() < _GRADED * factors.min():
            operator = operator / np.outer(1 / factors, factors)
            factors = np.ones(len(factors))
        form, vectors = leading_schur_form(operator, chosen)
    basis = solve_triangular(root, factors[:, None] * vectors, trans="T", lower=True)
    own = np.asfortranarray(basis[rows])
    graded = bool(factors.max() > factors.min())
    inverse = np.linalg.inv(form) if len(form) else form
    projected = inverse + op.shift * np.eye(len(form))
    return InvariantSubspace(own, projected, op.symmetric, whole=not disc_only, graded=graded)


def _gathered(op: ShiftInvert) -> tuple[Floats, Floats, slice]:
    """L^T OP L^-T on every rank, L of the inner product L L^T, and the rows of this rank."""
    comm = op.comm.tompi4py()
    first = sum(comm.allgather(op.local)[: op.rank])
    rows = slice(first, first + op.local)
    own = np.zeros((op.local, op.rows), order="F")
    own[:, rows] = np.eye(op.local)
    product = op.image(own)
    operator = np.empty_like(own)
    for block in column_blocks(op.rows):
        part, image = (np.asfortranarray(each[:, block]) for each in (own, product))
        operator[:, block] = op.apply(part, image)
    operator, product = (np.vstack(comm.allgather(each)) for each in (operator, product))
    root = cholesky(symmetric_part(product), lower=True)
    scaled = solve_triangular(root, (root.T @ operator).T, lower=True).T
    return scaled, root, rows


def _kept(
    op: ShiftInvert, radius: Callable[[Complexes], float], disc_only: bool, theta: Complexes
) -> Any:
    """Which of all theta are in the disc or in the window; infinite eigenvalues are not."""
    sizes = np.abs(theta)
    finite = np.zeros(len(theta), dtype=bool)
    finite[np.argsort(-sizes)[: op.finite]] = True
    finite &= sizes > max(_ROUNDING * sizes.max(initial=0.0), op.negligible / abs(op.shift))
    disc = sizes * radius(theta[finite]) >= 1
    others = False if disc_only else ~op.outside(theta, np.zeros(len(theta)))
    return finite & (disc | others)


def leading_schur_form(
    operator: Floats, chosen: Callable[[Complexes], Any]
) -> tuple[Floats, Floats]:
    """Schur form of OP on those eigenvalues, and its vectors."""
    form, vectors = schur(operator, output="real")
    every = np.ones(len(form), dtype=np.int32)
    _, _, re, im, *_ = dtrsen(every, form, vectors, job="N")
    kept = chosen(re + 1j * im)
    form, vectors, _, _, number, _, _, info = dtrsen(kept.astype(np.int32), form, vectors, job="N")
    if info:
        raise LinAlgError("eigenvalues of a small matrix cannot be told from others")
    return form[:number, :number], vectors[:, :number]
