"""Approximate eigenvectors improved on a pencil: block inverse steps, each with a Rayleigh-Ritz.

For vectors X with eigenvalues Lambda (kappa = -lambda^2) and one real shift sigma,

    A(sigma) [X'; F] = [R; 0],    R = (kappa - sigma) M X - lambda D X

is the step of inverse iteration, X' = X - A(sigma)^-1 (lambda^2 M + lambda D + K) X, that also
takes from X what does not obey the contact: forces F come with displacements, and
K X' + L^T F = R + sigma M X' needs no product with K. With the same for left vectors Y, the
problem is projected on both. Without damping that is, at the cost of one factorisation and one
block of solves a side, the two-sided Rayleigh-Ritz of a Krylov space; components of another
eigenvalue kappa_j in the error of an eigenvalue shrink by ((kappa - sigma) / (kappa_j - sigma))^2.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.blocks import all_inner, column_blocks, columns_inner, times
from cea.eigen.dense_products import beside, combined
from cea.eigen.pencil import Matrices
from cea.eigen.quadratic_damping import Damping
from cea.eigen.quadratic_pairs import QuadraticSizes
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError
from cea.nested.approximation import Approximation, growing, matched, one_of_each_pair
from cea.nested.remaining import bounds_by_changes
from cea.nested.ritz import mean_with_transpose, quadratic_ritz, ritz

_BESIDE = 0.997
"""Part of a shift that is an eigenvalue at which another is tried."""
_SMALLEST = 1e-16
"""Length of a direction, relative to the longest, that counts for no less."""


@dataclass(frozen=True)
class Step:
    """What a step makes of an approximation.

    Parameters
    ----------
    approximation
        The new one, in the order of the old one.
    remaining
        How far the eigenvalues are from those after the solve for the right vectors alone (1/s),
        shape (n,): more than they still err by.
    """

    approximation: Approximation
    remaining: Floats
    moved: object = None


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


class BlockSteps:
    """A pencil at a shift; what steps are made with.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    shift
        sigma (1/s^2); beside it where it is an eigenvalue.

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
            self.factors = Shifted(matrices, _BESIDE * shift)
        self._damping = Damping(matrices)

    def free(self) -> None:
        """Free the factors."""
        self.factors.free()
        self._damping.free()

    def improved(self, old: Approximation, steps: int, allowed: Floats | None = None) -> Step:
        """Right and left vectors after some steps, eigenvalues of the projected problem.

        Without damping it is projected on the vectors of all steps together, a Krylov space, and
        modes of which more remains than is allowed (1/s), shape (n,), take one step more.
        """
        if not self.matrices.quadratic:
            return self._linear(old, steps, allowed)
        return self._quadratic(old, steps, self._damping)

    def one_sided(self, old: Approximation) -> Complexes:
        """Eigenvalues after a step for the right vectors alone, shape (n,).

        An error of left vectors, which stay as they are, counts only times one that is left in the
        right ones. With damping, and where both are the same, it is a whole step.
        """
        if self.matrices.quadratic or self.matrices.symmetric:
            return self.improved(old, 1).approximation.eigenvalues
        chosen = one_of_each_pair(old.eigenvalues)
        values = old.eigenvalues[chosen]
        right = self._krylov(self._real_basis(values, old.right[:, chosen]), 1)
        C = self._orthonormal(self._real_basis(values, old.left[:, chosen]))
        B, X = self._unit(right)
        mu = ritz(self._inner(C.own, B.image), self._inner(C.own, X.image))[0]
        found = growing(self.factors.kappa + mu)
        return found[matched(old.eigenvalues, found)]

    def _linear(self, old: Approximation, steps: int, allowed: Floats | None) -> Step:
        """K x = kappa M x on real bases, once more with further vectors of some modes."""
        chosen, symmetric = one_of_each_pair(old.eigenvalues), self.matrices.symmetric
        values = old.eigenvalues[chosen]
        right = self._krylov(self._real_basis(values, old.right[:, chosen]), steps)
        left = right
        if not symmetric:
            start = self._real_basis(values, old.left[:, chosen])
            left = self._krylov(start, steps, transposed=True)
        base = right.start.own.shape[1] // steps
        step = self._projected_on(old, right, left, base, base)
        if allowed is None:
            return step
        found, late = step.approximation, step.remaining > allowed
        own = np.intersect1d(np.flatnonzero(late), one_of_each_pair(found.eigenvalues))
        if not len(own):
            return step
        right = self._extended(right, self._real_basis(found.eigenvalues[own], found.right[:, own]))
        if symmetric:
            left = right
        else:
            more = self._real_basis(found.eigenvalues[own], found.left[:, own])
            left = self._extended(left, more, transposed=True)
        newest = right.start.own.shape[1] - steps * base
        later = self._projected_on(old, right, left, base, newest)
        return Step(later.approximation, np.where(late, later.remaining, step.remaining))

    def _projected_on(
        self, old: Approximation, right: _Space, left: _Space, base: int, newest: int
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
        own = self._nearest_to(right.start.own[:, :base], vectors, images)
        found, half = (growing(self.factors.kappa + each) for each in (mu, halfway))
        order = own[matched(old.eigenvalues, found[own])]
        x = self._scaled(vectors[:, order], images[:, order])
        y = x
        if not symmetric:
            y = self._scaled(combined(Y.own, d[:, order]), combined(Y.image, d[:, order]))
        new = Approximation(found[order], x, y)
        half = half[matched(new.eigenvalues, half)]
        bounds = bounds_by_changes(-(found[order] ** 2), -(half**2), -(old.eigenvalues**2))
        bounds = np.minimum(np.sqrt(bounds), bounds / np.maximum(np.abs(new.eigenvalues), np.finfo(float).tiny))
        return Step(new, bounds + self._rounding(new, self._damping), (found[order],half,old.eigenvalues))

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

    def _quadratic(self, old: Approximation, steps: int, damping: Damping) -> Step:
        """lambda^2 M + lambda D + K projected on the vectors of all steps and of one more."""
        start = before = old
        none = np.empty((len(old.right), 0), order="F")
        V, force, W = none, none, none
        for _ in range(steps + 1):
            R = self._forces(damping, old.eigenvalues, old.right)
            V, force = self._grown(V, force, self._solved(R), R)
            L = self._forces(damping, old.eigenvalues.conj(), old.left, transposed=True)
            Y = self._solved(L, transposed=True)
            W = self._grown(W, W, Y, Y)[0]
            earlier, before, old = before, old, self._ritz(V, force, W, start.eigenvalues, old.eigenvalues, damping)
        bounds = bounds_by_changes(old.eigenvalues, before.eigenvalues, earlier.eigenvalues)
        return Step(old, bounds + self._rounding(old, damping), (old.eigenvalues,before.eigenvalues,earlier.eigenvalues))

    def _rounding(self, new: Approximation, damping: Damping) -> Floats:
        """What rounding the entries of the matrices does to eigenvalues (1/s), shape (n,)."""
        sizes, comm = QuadraticSizes(self.matrices, damping), self.matrices.stiffness.comm
        none = np.zeros((self.factors.multipliers, len(new.eigenvalues)), dtype=complex)
        works = [
            columns_inner(np.abs(each), sizes.forces(new.eigenvalues, each, none), comm)
            for each in (new.right, new.left)
        ]
        sizes.free()
        inertia = columns_inner(new.left, times(self.matrices.mass, new.right), comm)
        slopes = 2 * new.eigenvalues * inertia + columns_inner(new.left, damping.times(new.right), comm)
        tiny = np.finfo(float).tiny
        error = np.finfo(float).eps * np.sqrt(works[0] * works[1])
        return np.minimum(error / np.maximum(np.abs(slopes), tiny), np.sqrt(error / np.maximum(np.abs(inertia), tiny)))

    def _ritz(self, V, force, W, first, values, damping) -> Approximation:
        M = self.matrices.mass
        inertia, drag = times(M, V), damping.times(V)
        parts = (force + self.factors.kappa * inertia, drag, inertia)
        found, c, d = quadratic_ritz(*(self._inner(W, part) for part in parts))
        order = matched(values, found)
        x, y = V @ c[:, order], W @ d[:, order]
        x, y = (self._scaled(each, times(M, each)) for each in (x, y))
        return Approximation(found[order], x, y)

    def _grown(self, basis, loads, vectors, forces):
        """An M-orthonormal real basis with real and imaginary parts of further vectors, their forces alike."""
        vectors, forces = (np.hstack([each.real, each.imag]) for each in (vectors, forces))
        M = self.matrices.mass
        sizes = np.sqrt(columns_inner(vectors, times(M, vectors), self.matrices.stiffness.comm))
        sizes = np.hypot(*np.split(sizes, 2))
        vectors, forces = (each / np.tile(sizes, 2) for each in (vectors, forces))
        for _ in range(2):
            inside = self._inner(basis, times(M, vectors))
            vectors, forces = vectors - combined(basis, inside), forces - combined(loads, inside)
            gram = self._inner(vectors, times(M, vectors))
            squares, axes = np.linalg.eigh(mean_with_transpose(gram))
            axes = axes[:, squares > 1e-14] / np.sqrt(squares[squares > 1e-14])
            vectors, forces = combined(vectors, axes), combined(forces, axes)
        return beside(basis, vectors), beside(loads, forces)

    def _forces(
        self, damping: Damping, values: Complexes, x: Complexes, *, transposed: bool = False
    ) -> Complexes:
        """(kappa - sigma) M x - lambda D x, or with D^T."""
        shifted = -(values**2) - self.factors.kappa
        drag = damping.times(x, transposed=transposed)
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
            lengths = np.sqrt(np.maximum(squares, _SMALLEST * squares.max(initial=0.0)))
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
