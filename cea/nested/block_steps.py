"""Block inverse iteration with Rayleigh-Ritz projection, which improves given eigenvectors.

For vectors X with eigenvalues Lambda (kappa = -lambda^2) and one real shift sigma,

    A(sigma) [X'; F] = [R; 0],    R = (kappa - sigma) M X - lambda D X

is the step of inverse iteration, X' = X - A(sigma)^-1 (lambda^2 M + lambda D + K) X. It also
removes components of X that violate contact constraints, because contact forces F are solved for
together with the displacements. K X' + L^T F = R + sigma M X' needs no product with K. After the
same step for left vectors Y, the problem is projected on real and imaginary parts of the vectors of
all steps. The contribution of another eigenvalue kappa_j to the error of an eigenvalue kappa
decreases by ((kappa - sigma) / (kappa_j - sigma))^2.

With damping lambda^2 M + lambda D + K itself is projected. Projecting its companion form on vectors
[x; lambda x] would be one Newton step from the old lambda, with an error of the square of the
correction over 2 lambda even for exact x.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from cea.arrays import Complexes, Floats
from cea.eigen.block_products import (
    all_inner,
    beside,
    column_blocks,
    columns_inner,
    combined,
    times,
)
from cea.eigen.matching import assign
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError

_DEPENDENT = 1e-13
"""Relative singular value of inner products below which vectors are linearly dependent."""


@dataclass(frozen=True)
class Approximation:
    """Approximate lambda (1/s) with right x and left y, y^H (lambda^2 M + lambda D + K) = 0."""

    eigenvalues: Complexes
    right: Complexes
    left: Complexes


@dataclass(frozen=True)
class _Spanned:
    """M-orthonormal vectors V, forces of A(sigma) [V; F] = [forces; 0] (or with A^T), and M V.

    The three are stacked, so that one product forms linear combinations of all three.
    """

    rows: Floats

    @property
    def own(self) -> Floats:
        return self.rows[: len(self.rows) // 3]

    @property
    def forces(self) -> Floats:
        return self.rows[len(self.rows) // 3 : 2 * len(self.rows) // 3]

    @property
    def inertia(self) -> Floats:
        return self.rows[2 * len(self.rows) // 3 :]


class BlockSteps:
    """A pencil factorised at a shift (1/s^2), or at half the shift if that fails."""

    def __init__(self, matrices: Matrices, shift: float) -> None:
        self.matrices = matrices
        try:
            self.factors = Shifted(matrices, shift)
        except ConvergenceError:
            self.factors = Shifted(matrices, 0.5 * shift)

    def free(self) -> None:
        """Free the factors."""
        self.factors.free()

    def improved(self, old: Approximation, steps: int) -> tuple[Approximation, list[Floats]]:
        """Return the approximation after some steps, and the change of lambda (1/s) in each."""
        right = left = _Spanned(np.empty((3 * len(old.right), 0), order="F"))
        alike = self.matrices.symmetric and self.matrices.gyroscopic is None
        changes = []
        for _ in range(steps):
            before = old.eigenvalues
            fresh = self._outside(right, before, old.right)
            right = _Spanned(beside(right.rows, fresh.rows))
            if not alike:
                fresh = self._outside(left, before.conj(), old.left, transposed=True)
            left = right if alike else _Spanned(beside(left.rows, fresh.rows))
            old = self._projected(before, right, left)
            changes.append(np.abs(old.eigenvalues - before))
        return old, changes

    def _projected(self, wanted: Complexes, right: _Spanned, left: _Spanned) -> Approximation:
        """Return eigenpairs of the projected problem, matched with the wanted eigenvalues."""
        V, W = right.own, left.own
        internal = right.forces + self.factors.kappa * right.inertia  # K V + L^T F
        works, masses = self._inner(W, internal), self._inner(W, right.inertia)
        if self.matrices.quadratic:
            found, c, d = _ritz(works, masses, self._inner(W, self.matrices.drag(V)))
        elif self.matrices.symmetric:
            found, c, d = _symmetric_ritz(works, masses)
        else:
            found, c, d = _ritz(works, masses)
        order = assign(np.abs(wanted[:, None] - found))[1]
        c, d = (each[:, order] / np.linalg.norm(each[:, order], axis=0) for each in (c, d))
        return Approximation(found[order], V @ c, W @ d)

    def _outside(
        self, space: _Spanned, values: Complexes, x: Complexes, *, transposed: bool = False
    ) -> _Spanned:
        """Return an M-orthonormal real basis of the new vectors, orthogonal to a space."""
        loads, alone = self._real_parts(values, self._forces(values, x, transposed=transposed))
        own = self._solved(loads, transposed=transposed)
        inertia = times(self.matrices.mass, own)
        squares = columns_inner(own, inertia, self.matrices.stiffness.comm)
        parts = squares[alone:].reshape(2, -1)  # real and imaginary parts have one common length
        lengths = np.sqrt(np.concatenate([squares[:alone], np.tile(parts.sum(axis=0), 2)]))
        new = _Spanned(np.asfortranarray(np.vstack([own, loads, inertia]) / lengths))
        for _ in range(2):
            inside = self._inner(space.own, new.inertia)
            new = _Spanned(new.rows - combined(space.rows, inside))
            gram = self._inner(new.own, new.inertia)
            sizes, axes = np.linalg.eigh(0.5 * (gram + gram.T))
            kept = sizes > _DEPENDENT
            new = _Spanned(combined(new.rows, axes[:, kept] / np.sqrt(sizes[kept])))
        return new

    def _real_parts(self, values: Complexes, columns: Complexes) -> tuple[Floats, int]:
        """Return real and imaginary parts as columns, after a number of purely real columns.

        Without damping, vectors of a real lambda^2 are real up to a phase.
        """
        real = (values.imag == 0) | (values.real == 0)
        real &= not self.matrices.quadratic
        comm = self.matrices.stiffness.comm.tompi4py()
        squares = comm.allreduce((columns[:, real] ** 2).sum(axis=0))
        turned = columns[:, real] * np.exp(-0.5j * np.angle(squares))
        parts = [turned.real, columns[:, ~real].real, columns[:, ~real].imag]
        return np.asfortranarray(np.hstack(parts)), int(real.sum())

    def _forces(self, values: Complexes, x: Complexes, *, transposed: bool = False) -> Complexes:
        """Return (kappa - sigma) M x - lambda D x, or with D^T; without damping M x (same span)."""
        inertia = times(self.matrices.mass, x)
        if not self.matrices.quadratic:  # kappa may be sigma
            return np.asarray(inertia)
        drag = self.matrices.drag(x, transposed=transposed)
        return np.asarray((-(values**2) - self.factors.kappa) * inertia - values * drag)

    def _solved(self, forces: Floats, *, transposed: bool = False) -> Floats:
        """Return the displacements of A(sigma)^-1 forces, or of A(sigma)^-T forces."""
        x = np.empty(forces.shape, order="F")
        for block in column_blocks(forces.shape[1]):
            columns = np.asfortranarray(forces[:, block])
            x[:, block] = self.factors.solve_block(columns, transposed=transposed)
        return x

    def _inner(self, left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
        return all_inner(left, right, self.matrices.stiffness.comm)


def _symmetric_ritz(works: Floats, masses: Floats) -> tuple[Complexes, Complexes, Complexes]:
    """As :func:`_ritz`, for symmetric matrices: every kappa is real."""
    sizes, axes = np.linalg.eigh(0.5 * (masses + masses.T))
    large = sizes > _DEPENDENT * sizes.max()
    basis = axes[:, large] / np.sqrt(sizes[large])
    own = basis.T @ works @ basis
    kappa, z = np.linalg.eigh(0.5 * (own + own.T))
    vectors = (basis @ z).astype(complex)
    return _lambda_of(kappa), vectors, vectors


def _ritz(
    works: Floats, masses: Floats, drags: Floats | None = None
) -> tuple[Complexes, Complexes, Complexes]:
    """Return lambda, right and left vectors of lambda^2 masses + lambda drags + works.

    Bases may be linearly dependent: negligible singular values of ``masses`` are dropped.
    """
    u, sizes, vt = np.linalg.svd(masses)
    count = int(np.sum(sizes > _DEPENDENT * sizes.max()))
    U, V = u[:, :count] / sizes[:count], vt[:count].T
    stiffness = U.T @ works @ V
    if drags is None:
        kappa, w, z = eig(stiffness, left=True)
        return _lambda_of(kappa), V @ z + 0j, U @ w + 0j
    scale = np.sqrt(np.abs(stiffness).max()) or 1.0
    one, none = np.eye(count), np.zeros((count, count))
    damping = U.T @ drags @ V
    companion = np.block([[none, one], [-stiffness / scale**2, -damping / scale]])
    found, w, z = eig(companion, left=True)
    return scale * found, V @ z[:count] + 0j, U @ w[count:] + 0j


def _lambda_of(kappa: NDArray[Any]) -> Complexes:
    """Return lambda with Im lambda >= 0 from kappa = -lambda^2; real lambda are positive."""
    values = np.sqrt(-np.asarray(kappa, dtype=complex))
    values = np.where(values.imag < 0, -values, values) + 0j
    return np.where(values.imag == 0, np.abs(values.real), values)
