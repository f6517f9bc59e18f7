"""All eigenvalues of a small pencil about a shift, by LAPACK: none can be missing.

The inverted operator is applied to the identity: relative to the shift its eigenvalues near the
window are large, and stiff penalties, which are small in it, leave them their digits. Where
entries of the matrix are far apart, LAPACK balances it by powers of two first. Eigenvectors are
then orthogonal in units of their own, and only left vectors tell the errors.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import LinAlgError, cholesky, matrix_balance, schur, solve_triangular
from scipy.linalg.lapack import dtrsen

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import column_blocks
from cea.eigen.shift_invert import ShiftInvert
from cea.eigen.subspace import InvariantSubspace, symmetric_part

type Radius = Callable[[Complexes], float]
"""Radius of the disc about the shift that is searched, from the theta that are known."""

_ROUNDING = 1e-13
"""theta relative to the largest that may be rounding of zero."""
_GRADED = 64.0
"""Ratio of the factors of balancing from which on norms say nothing."""


def dense_subspace(
    op: ShiftInvert, radius: Radius, *, disc_only: bool = False
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
        form, vectors = _leading(operator, chosen)
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


def _kept(op: ShiftInvert, radius: Radius, disc_only: bool, theta: Complexes) -> Any:
    """Which of all theta are in the disc or in the window; infinite eigenvalues are not."""
    sizes = np.abs(theta)
    finite = np.zeros(len(theta), dtype=bool)
    finite[np.argsort(-sizes)[: op.finite]] = True
    finite &= sizes > max(_ROUNDING * sizes.max(initial=0.0), op.negligible / abs(op.shift))
    disc = sizes * radius(theta[finite]) >= 1
    others = False if disc_only else ~op.outside(theta, np.zeros(len(theta)))
    return finite & (disc | others)


def _leading(operator: Floats, chosen: Callable[[Complexes], Any]) -> tuple[Floats, Floats]:
    """Schur form of OP on those eigenvalues, and its vectors."""
    form, vectors = schur(operator, output="real")
    every = np.ones(len(form), dtype=np.int32)
    _, _, re, im, *_ = dtrsen(every, form, vectors, job="N")
    kept = chosen(re + 1j * im)
    form, vectors, _, _, number, _, _, info = dtrsen(kept.astype(np.int32), form, vectors, job="N")
    if info:
        raise LinAlgError("eigenvalues of a small matrix cannot be told from others")
    return form[:number, :number], vectors[:, :number]
