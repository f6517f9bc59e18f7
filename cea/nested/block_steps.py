"""Approximate eigenvectors improved on a pencil: block inverse steps, each with a Rayleigh-Ritz.

For vectors X with eigenvalues Lambda (kappa = -lambda^2) and one real shift sigma,

    A(sigma) [X'; F] = [R; 0],    R = (kappa - sigma) M X - lambda D X

is the step of inverse iteration, X' = X - A(sigma)^-1 (lambda^2 M + lambda D + K) X, that also
takes from X what does not obey the contact: forces F come with displacements, and
K X' + L^T F = R + sigma M X' needs no product with K. With the same for left vectors Y, the
problem is projected on both. Without damping that is, at the cost of one factorisation and one
block of solves a side, the two-sided Rayleigh-Ritz of a Krylov space; components of another
eigenvalue kappa_j in the error of an eigenvalue shrink by ((kappa - sigma) / (kappa_j - sigma))^2.

With damping lambda^2 M + lambda D + K itself is projected, on real and imaginary parts of the
vectors of all steps. Its companion form on vectors [x; lambda x] would be one Newton step from the
old lambda, which errs by the square of the correction over 2 lambda whatever x is.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigvals

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.blocks import all_inner, beside, column_blocks, columns_inner, combined, times
from cea.eigen.pencil import Matrices
from cea.eigen.residuals import Damping
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError
from cea.nested.remaining import left_of_errors
from cea.nested.ritz import (
    DEPENDENT,
    Approximation,
    growing,
    matched,
    mean_with_transpose,
    one_of_each_pair,
    quadratic_ritz,
    ritz,
)


@dataclass(frozen=True)
class Step:
    """What a step makes of an approximation.

    Parameters
    ----------
    approximation
        The new one, in the order of the old one.
    remaining
        Bounds on what they still err by (1/s), shape (n,), by what the last solves changed
        (:mod:`cea.nested.remaining`).
    """

    approximation: Approximation
    remaining: Floats


@dataclass(frozen=True)
class _Vectors:
    """Real vectors V with M V, which is as dear as all else: it is made of products once."""

    own: Floats
    image: Floats

    def __matmul__(self, coefficients: Floats) -> "_Vectors":
        return _Vectors(combined(self.own, coefficients), combined(self.image, coefficients))

    def __truediv__(self, lengths: Floats) -> "_Vectors":
        own, image = (np.asfortranarray(part / lengths) for part in (self.own, self.image))
        return _Vectors(own, image)

    def beside(self, other: "_Vectors") -> "_Vectors":
        return _Vectors(beside(self.own, other.own), beside(self.image, other.image))


@dataclass(frozen=True)
class _Space:
    """M-orthonormal vectors B, and X = A(sigma)^-1 M B."""

    start: _Vectors
    solved: _Vectors


@dataclass(frozen=True)
class _Spanned:
    """M-orthonormal vectors V, and A(sigma) [V; F] = [forces; 0], or that with A^T."""

    own: Floats
    forces: Floats

    def beside(self, other: "_Spanned") -> "_Spanned":
        return _Spanned(beside(self.own, other.own), beside(self.forces, other.forces))


class BlockSteps:
    """A pencil at a shift; what steps are made with.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    shift
        sigma (1/s^2); half of it where it is an eigenvalue.

    Attributes
    ----------
    factors
        The pencil factorised.
    """

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

    def improved(self, old: Approximation, steps: int) -> Step:
        """Right and left vectors after some steps, eigenvalues of the projected problem.

        Without damping it is projected on the vectors of all steps together, a Krylov space. With
        damping all modes take one step more, which bounds what remains.
        """
        if not self.matrices.quadratic:
            return self._linear(old, steps)
        return self._quadratic(old, steps)

    def _linear(self, old: Approximation, steps: int) -> Step:
        """K x = kappa M x on real bases."""
        chosen = one_of_each_pair(old.eigenvalues)
        values = old.eigenvalues[chosen]
        left = right = self._krylov(self._real_basis(values, old.right[:, chosen]), steps)
        if not self.matrices.symmetric:
            start = self._real_basis(values, old.left[:, chosen])
            left = self._krylov(start, steps, transposed=True)
        return self._projected_on(old, right, left, right.start.own.shape[1] // steps)

    def _projected_on(
        self,
        old: Approximation,
        right: _Space,
        left: _Space,
        newest: int,
    ) -> Step:
        """With X = A(sigma)^-1 M B the problem is (Y^T M B, Y^T M X)."""
        symmetric = self.matrices.symmetric
        (B, X), Y = self._unit(right), self._unit(left)[1]
        # Of unit length, as Y is: a span of very long and short vectors would lose the short.
        lagging = np.hstack([Y.own[:, :-newest], left.start.own[:, -newest:]])
        halfway = ritz(self._inner(lagging, B.image), self._inner(lagging, X.image))[0]
        forces, inertia = self._inner(Y.own, B.image), self._inner(Y.own, X.image)
        mu, c, d = ritz(forces, inertia, symmetric=symmetric)
        vectors, images = combined(X.own, c), combined(X.image, c)
        own = self._nearest_to(right.start.own[:, :newest], vectors, images)
        found, half = (growing(self.factors.kappa + each) for each in (mu, halfway))
        order = own[matched(old.eigenvalues, found[own])]
        x = self._scaled(vectors[:, order], images[:, order])
        y = x
        if not symmetric:
            y = self._scaled(combined(Y.own, d[:, order]), combined(Y.image, d[:, order]))
        new = Approximation(found[order], x, y)
        half = half[matched(new.eigenvalues, half)]
        return self._with_bounds(new, (half, old.eigenvalues), np.zeros(len(half)))

    def _nearest_to(self, basis: Floats, vectors: Complexes, images: Complexes) -> Ints:
        """As many vectors as an M-orthonormal basis has, those that are most of it."""
        sizes = columns_inner(vectors, images, self.matrices.stiffness.comm).real
        share = (np.abs(self._inner(basis, images)) ** 2).sum(axis=0) / sizes
        return np.sort(np.argsort(-share, kind="stable")[: basis.shape[1]])

    def _krylov(self, vectors: Floats, steps: int, *, transposed: bool = False) -> _Space:
        """The Krylov space of some vectors after so many steps."""
        start = self._orthonormal(vectors)
        block = self._solved(start.image, transposed=transposed)
        space = _Space(start, self._with_image(block))
        for _ in range(steps - 1):
            space = self._extended(space, block, transposed=transposed)
            block = space.solved.own[:, -block.shape[1] :]
        return space

    def _extended(self, space: _Space, vectors: Floats, *, transposed: bool = False) -> _Space:
        """A space with further vectors, made orthonormal to those before."""
        B = space.start
        for _ in range(2):
            inside = self._inner(B.image, vectors)
            fresh = self._orthonormal(vectors - combined(B.own, inside))
            vectors = fresh.own
        block = self._solved(fresh.image, transposed=transposed)
        return _Space(B.beside(fresh), space.solved.beside(self._with_image(block)))

    def _unit(self, space: _Space) -> tuple[_Vectors, _Vectors]:
        """B and X with the columns of X of unit length."""
        X, comm = space.solved, self.matrices.stiffness.comm
        lengths = np.sqrt(columns_inner(X.own, X.image, comm))
        return space.start / lengths, X / lengths

    def _quadratic(self, old: Approximation, steps: int) -> Step:
        """The quadratic problem projected on the vectors of all steps, and of one more.

        The last step tells what the others left.
        """
        damping, none = self._damping, np.empty((len(old.right), 0), order="F")
        right = left = _Spanned(none, none)
        before = old
        for _ in range(steps + 1):
            R = self._forces(old.eigenvalues, old.right)
            L = self._forces(old.eigenvalues.conj(), old.left, transposed=True)
            fresh = self._outside(right, self._solved(R), R)
            right = right.beside(fresh)
            left = left.beside(self._outside(left, self._solved(L, transposed=True), L))
            earlier, before, old = before, old, self._projected(old.eigenvalues, right, left)
        work = self._inner(fresh.own, self._internal(fresh))
        drag = self._inner(fresh.own, damping.times(fresh.own))
        damped = np.abs(eigvals(drag, work)) if work.size else np.zeros(1)
        slowest = (np.abs(old.eigenvalues) * damped.max()) ** 2
        return self._with_bounds(old, (before.eigenvalues, earlier.eigenvalues), slowest)

    def _projected(self, wanted: Complexes, right: "_Spanned", left: "_Spanned") -> Approximation:
        """Eigenvalues of the projected quadratic problem that belong to those wanted."""
        M, V, W = self.matrices.mass, right.own, left.own
        parts = (self._internal(right), self._damping.times(V), times(M, V))
        found, c, d = quadratic_ritz(*(self._inner(W, part) for part in parts))
        order = matched(wanted, found)
        x, y = V @ c[:, order], W @ d[:, order]
        x, y = (self._scaled(each, times(M, each)) for each in (x, y))
        return Approximation(found[order], x, y)

    def _internal(self, space: "_Spanned") -> Floats:
        """K V + L^T F of displacements V and the forces F that come with them."""
        return np.asarray(space.forces + self.factors.kappa * times(self.matrices.mass, space.own))

    def _outside(self, space: "_Spanned", vectors: Complexes, forces: Complexes) -> "_Spanned":
        """What real and imaginary parts of vectors span beside a space."""
        M, comm = self.matrices.mass, self.matrices.stiffness.comm
        own, loads = (np.hstack([each.real, each.imag]) for each in (vectors, forces))
        lengths = np.tile(np.sqrt(columns_inner(vectors, times(M, vectors), comm).real), 2)
        own, loads = own / lengths, loads / lengths
        for _ in range(2):
            inside = self._inner(space.own, times(M, own))
            own, loads = own - combined(space.own, inside), loads - combined(space.forces, inside)
            gram = self._inner(own, times(M, own))
            squares, axes = np.linalg.eigh(mean_with_transpose(gram))
            kept = squares > DEPENDENT
            axes = axes[:, kept] / np.sqrt(squares[kept])
            own, loads = combined(own, axes), combined(loads, axes)
        return _Spanned(own, loads)

    def _with_bounds(
        self, new: Approximation, before: tuple[Complexes, Complexes], slowest: Floats
    ) -> Step:
        left = left_of_errors(
            new, before, slowest, self.matrices, self._damping, self.factors.kappa
        )
        return Step(new, left)

    def _forces(self, values: Complexes, x: Complexes, *, transposed: bool = False) -> Complexes:
        """(kappa - sigma) M x - lambda D x, or with D^T."""
        shifted = -(values**2) - self.factors.kappa
        drag = self._damping.times(x, transposed=transposed)
        return np.asarray(shifted * times(self.matrices.mass, x) - values * drag)

    def _solved(self, forces: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Displacements of A(sigma)^-1, or of its transpose, for blocks of real columns."""
        if np.iscomplexobj(forces):
            real, imaginary = (
                self._solved(part, transposed=transposed) for part in (forces.real, forces.imag)
            )
            return np.asarray(real + 1j * imaginary)
        x = np.empty(forces.shape, order="F")
        for block in column_blocks(forces.shape[1]):
            columns = np.asfortranarray(forces[:, block])
            x[:, block] = self.factors.solve_block(columns, transposed=transposed)
        return x

    def _inner(self, left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
        return all_inner(left, right, self.matrices.stiffness.comm)

    def _real_basis(self, eigenvalues: Complexes, vectors: Complexes) -> Floats:
        """Real vectors of real lambda^2, real and imaginary parts of others."""
        alone = (eigenvalues.real == 0) | (eigenvalues.imag == 0)
        comm = self.matrices.stiffness.comm.tompi4py()
        squares = comm.allreduce((vectors[:, alone] ** 2).sum(axis=0))
        turned = vectors[:, alone] * np.exp(-0.5j * np.angle(squares))  # their phase is any
        parts = [turned.real, vectors[:, ~alone].real, vectors[:, ~alone].imag]
        return np.asfortranarray(np.hstack(parts))

    def _orthonormal(self, vectors: Floats) -> _Vectors:
        """An M-orthonormal basis of columns, which may be nearly parallel."""
        for _ in range(2):
            basis = self._with_image(vectors)
            gram = self._inner(basis.own, basis.image)
            sizes = np.maximum(np.sqrt(np.abs(np.diag(gram))), np.finfo(float).tiny)
            squares, axes = np.linalg.eigh(mean_with_transpose(gram / sizes / sizes[:, None]))
            lengths = np.sqrt(np.maximum(squares, np.finfo(float).eps * squares.max(initial=0.0)))
            basis @= axes / sizes[:, None] / lengths
            vectors = basis.own
        return basis

    def _with_image(self, vectors: Floats) -> _Vectors:
        own = np.asfortranarray(vectors)
        return _Vectors(own, times(self.matrices.mass, own))

    def _scaled(self, vectors: Complexes, images: Complexes) -> Complexes:
        """Vectors with x^H M x = 1, of vectors and their products with M."""
        squares = columns_inner(vectors, images, self.matrices.stiffness.comm).real
        return np.asarray(vectors / np.sqrt(squares))


def middle_shift(eigenvalues: Complexes) -> float:
    """Shift amid eigenvalues (1/s^2), about which steps shrink errors of all of them."""
    kappa = -(eigenvalues**2).real
    return float(0.5 * (kappa.min() + kappa.max()))
