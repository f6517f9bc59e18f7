"""Invariant subspaces of a pencil and their eigenpairs; dense computation for small pencils.

For a small pencil the shift-and-invert operator is formed by applying it to the identity, so that
no eigenvalue can be missed. Its eigenvalues near the window are large; stiff penalties, which give
small ones, cost them no digits. Where the entries of the matrix differ much in size, LAPACK
balances it by powers of two first. The basis is then orthonormal in scaled unknowns instead of in
M, and errors can only be estimated with left vectors.
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
"""Function that computes the radius of a disc from its shift and the current Ritz values theta."""

_ROUNDING = 1e-13
"""Size of theta relative to the largest below which it counts as zero."""
_GRADED = 64.0
"""Ratio of the largest to the least balancing factor from which on balancing is applied."""


@dataclass(frozen=True)
class InvariantSubspace:
    """Vectors Q, M-orthonormal, with M^-1 K Q = Q R, R block upper triangular."""

    basis: Floats  # Q, the rows of this rank, shape (n_local, k)
    projected: Floats  # R (1/s^2), shape (k, k)
    symmetric: bool  # whether R is symmetric but for rounding, as without friction
    whole: bool = False  # whether it holds all of the window, as computed by LAPACK
    graded: bool = False  # whether Q is orthonormal in balanced unknowns, and not in M

    @classmethod
    def empty(cls, rows: int, *, symmetric: bool) -> "InvariantSubspace":
        """Return the subspace of dimension zero with the given number of rows on this rank."""
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
        """Return eigenvalues, shape (k,), and the first rows of eigenvectors, shape (rows, k).

        Each eigenvalue is followed by its conjugate, whose vector is the conjugate vector. They are
        sorted by Re sqrt(kappa), which is Im lambda without damping.
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
        """Return the dual basis of the eigenvectors in Q, (k, k); its norms are the conditions."""
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
        """Append V with OP [Q V] = [Q V] [(R - shift)^-1, coupling; 0, form]."""
        own = np.linalg.inv(form)
        # R is not recomputed from this shift: eigenvalues far from it would lose digits.
        across = -(self.projected - shift * np.eye(self.size)) @ coupling @ own
        own = own + shift * np.eye(len(form))
        nothing = np.zeros((len(form), self.size))
        projected = np.block([[self.projected, across], [nothing, own]])
        return type(self)(beside(self.basis, basis), projected, self.symmetric)


def symmetric_part(matrix: Floats) -> Floats:
    """Return the symmetric part."""
    return 0.5 * (matrix + matrix.T)


def small_eigenpairs(matrix: Floats, *, symmetric: bool) -> tuple[Complexes, Complexes]:
    """Return eigenvalues and eigenvectors of a small matrix."""
    values, vectors = np.linalg.eigh(symmetric_part(matrix)) if symmetric else np.linalg.eig(matrix)
    return values.astype(complex), vectors.astype(complex)


def _twins(values: Complexes) -> Ints:
    """Return the indices of conjugates: those that follow an eigenvalue with Im kappa > 0.

    Rounding may leave an eigenvalue with Im kappa < 0 without its conjugate.
    """
    return 1 + np.flatnonzero(values.imag > 0)


def _rising(values: Complexes) -> Ints:
    """Return the order of kappa by Re sqrt(kappa), which is Im lambda; pairs stay together."""
    twins = _twins(values)
    firsts = np.setdiff1d(np.arange(len(values)), twins)
    firsts = firsts[np.lexsort((-values[firsts].real, np.sqrt(values[firsts]).real))]
    followed = np.isin(firsts + 1, twins)
    pairs = np.stack([firsts, np.where(followed, firsts + 1, -1)], axis=1).ravel()
    return pairs[pairs >= 0]


def dense_subspace(
    op: ShiftInvert, radius: Callable[[Complexes], float], *, disc_only: bool = False
) -> InvariantSubspace:
    """Return the eigenvalues of a disc about the shift, and unless disc_only of the window.

    Collective.
    """
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
    """Return L^T OP L^-T and L on every rank, and the rows of this one; M = L L^T."""
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
    """Return which theta are in the disc or in the window; infinite eigenvalues are excluded."""
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
    """Return the Schur form of OP on the chosen eigenvalues, and its Schur vectors."""
    form, vectors = schur(operator, output="real")
    every = np.ones(len(form), dtype=np.int32)
    _, _, re, im, *_ = dtrsen(every, form, vectors, job="N")
    kept = chosen(re + 1j * im)
    form, vectors, _, _, number, _, _, info = dtrsen(kept.astype(np.int32), form, vectors, job="N")
    if info:
        raise LinAlgError("LAPACK cannot separate nearly equal eigenvalues of a Schur form")
    return form[:number, :number], vectors[:, :number]
