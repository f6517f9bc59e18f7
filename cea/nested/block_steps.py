"""Approximate eigenvectors improved on a pencil: block inverse steps, each with a Rayleigh-Ritz.

For vectors X with eigenvalues Lambda (kappa = -lambda^2) and one real shift sigma,

    A(sigma) [X'; F] = [R; 0],    R = (kappa - sigma) M X - lambda D X

is the step of inverse iteration, X' = X - A(sigma)^-1 (lambda^2 M + lambda D + K) X, that also
takes from X what does not obey the contact: forces F come with displacements, and
K X' + L^T F = R + sigma M X' needs no product with K. With the same for left vectors Y, the
problem is projected on real and imaginary parts of the vectors of all steps. Components of another
eigenvalue kappa_j in the error of an eigenvalue shrink by ((kappa - sigma) / (kappa_j - sigma))^2.

With damping lambda^2 M + lambda D + K itself is projected. Its companion form on vectors
[x; lambda x] would be one Newton step from the old lambda, which errs by the square of the
correction over 2 lambda whatever x is.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import all_inner, beside, column_blocks, columns_inner, combined, times
from cea.eigen.pencil import Damping, Matrices
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError
from cea.nested.ritz import (
    DEPENDENT,
    Approximation,
    growing,
    matched,
    one_of_each_pair,
    quadratic_ritz,
    ritz,
)


@dataclass(frozen=True)
class _Spanned:
    """M-orthonormal vectors V, A(sigma) [V; F] = [forces; 0] or that with A^T, and M V.

    The three below each other, so that combinations of vectors are those of all three.
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
    """A pencil factorised at a shift (1/s^2), or at half of it where that is an eigenvalue."""

    def __init__(self, matrices: Matrices, shift: float) -> None:
        self.matrices = matrices
        try:
            self.factors = Shifted(matrices, shift)
        except ConvergenceError:
            self.factors = Shifted(matrices, 0.5 * shift)
        self._damping = Damping(matrices)

    def free(self) -> None:
        """Free the factors."""
        self.factors.free()
        self._damping.free()

    def improved(self, old: Approximation, steps: int) -> tuple[Approximation, list[Floats]]:
        """Vectors and eigenvalues after some steps, and what each changed eigenvalues by (1/s)."""
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
        """Eigenvalues of the projected problem that belong to those wanted."""
        V, W = right.own, left.own
        internal = right.forces + self.factors.kappa * right.inertia  # K V + L^T F
        works, masses = self._inner(W, internal), self._inner(W, right.inertia)
        if self.matrices.quadratic:
            drags = self._inner(W, self._damping.times(V))
            found, c, d = quadratic_ritz(works, drags, masses)
        else:
            kappa, c, d = ritz(works, masses, symmetric=self.matrices.symmetric)
            found = growing(kappa)
        order = matched(wanted, found)
        c, d = (each[:, order] / np.linalg.norm(each[:, order], axis=0) for each in (c, d))
        return Approximation(found[order], V @ c, W @ d)

    def _outside(
        self, space: _Spanned, values: Complexes, x: Complexes, *, transposed: bool = False
    ) -> _Spanned:
        """What a step of vectors spans beside a space, in real numbers."""
        if not self.matrices.quadratic:
            chosen = one_of_each_pair(values)
            values, x = values[chosen], x[:, chosen]
        loads, alone = self._real_parts(values, self._forces(values, x, transposed=transposed))
        own = self._solved(loads, transposed=transposed)
        inertia = times(self.matrices.mass, own)
        squares = columns_inner(own, inertia, self.matrices.stiffness.comm)
        parts = squares[alone:].reshape(2, -1)  # real and imaginary ones have one length together
        lengths = np.sqrt(np.concatenate([squares[:alone], np.tile(parts.sum(axis=0), 2)]))
        new = _Spanned(np.asfortranarray(np.vstack([own, loads, inertia]) / lengths))
        for _ in range(2):
            inside = self._inner(space.own, new.inertia)
            new = _Spanned(new.rows - combined(space.rows, inside))
            gram = self._inner(new.own, new.inertia)
            sizes, axes = np.linalg.eigh(0.5 * (gram + gram.T))
            kept = sizes > DEPENDENT
            new = _Spanned(combined(new.rows, axes[:, kept] / np.sqrt(sizes[kept])))
        return new

    def _real_parts(self, values: Complexes, columns: Complexes) -> tuple[Floats, int]:
        """Real columns, and how many of them come first that have no imaginary parts.

        Without damping those of real lambda^2 are real, up to a phase.
        """
        real = (values.imag == 0) | (values.real == 0)
        real &= not self.matrices.quadratic
        comm = self.matrices.stiffness.comm.tompi4py()
        squares = comm.allreduce((columns[:, real] ** 2).sum(axis=0))
        turned = columns[:, real] * np.exp(-0.5j * np.angle(squares))
        parts = [turned.real, columns[:, ~real].real, columns[:, ~real].imag]
        return np.asfortranarray(np.hstack(parts)), int(real.sum())

    def _forces(self, values: Complexes, x: Complexes, *, transposed: bool = False) -> Complexes:
        """(kappa - sigma) M x - lambda D x, or with D^T; without damping M x, whose span it is."""
        inertia = times(self.matrices.mass, x)
        if not self.matrices.quadratic:  # kappa may be sigma
            return np.asarray(inertia)
        drag = self._damping.times(x, transposed=transposed)
        return np.asarray((-(values**2) - self.factors.kappa) * inertia - values * drag)

    def _solved(self, forces: Floats, *, transposed: bool = False) -> Floats:
        """Displacements of A(sigma)^-1, or of its transpose."""
        x = np.empty(forces.shape, order="F")
        for block in column_blocks(forces.shape[1]):
            columns = np.asfortranarray(forces[:, block])
            x[:, block] = self.factors.solve_block(columns, transposed=transposed)
        return x

    def _inner(self, left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
        return all_inner(left, right, self.matrices.stiffness.comm)


def middle_shift(eigenvalues: Complexes) -> float:
    """Shift amid eigenvalues (1/s^2), about which steps shrink errors of all of them."""
    kappa = -(eigenvalues**2).real
    return float(0.5 * (kappa.min() + kappa.max()))
