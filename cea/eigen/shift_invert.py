"""Shift-and-invert operators on a factorised pencil, as used by the Krylov-Schur method.

Without damping K x = kappa M x, and about a shift sigma

    OP = (K - sigma M)^-1 M,    theta = 1 / (kappa - sigma).

With z = lambda x / g the problem (lambda^2 M + lambda D + K) x = 0, D = C + Y, is linear too,

    lambda [ x ]   [        g z           ]
           [ z ] = [ -M^-1 (K x / g + D z) ],

and its inverse at a real shift s takes one solve with P(s) = s^2 M + s D + K:

    OP [ a ]   [       x         ]
       [ b ] = [ (a + s x) / g ],     P(s) x = -(g M b + s M a + D a).

The scale g is the end omega of the window, where x and z have equal norms; the inner product is M
for both, so that residuals are backward errors. All quantities are real.
"""

from copy import copy
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.block_products import all_inner, combined, times
from cea.eigen.pencil import Matrices
from cea.eigen.regions import outside_of_window, upper_end
from cea.eigen.shifted import Shifted

MARGIN = 0.005
"""Margin searched beyond both ends of a damped window relative to omega. It separates the window
from the first mode beyond, and includes conjugates of modes next to the real axis."""


class ShiftInvert:
    """Operator (K - sigma M)^-1 M about a shift sigma (1/s^2), with the inner product M.

    SingularError when the shift is an eigenvalue.

    Attributes
    ----------
    rows, local, finite
        Rows of its vectors on all ranks and on this one, and number of finite eigenvalues.
    scale, reach
        omega (1/s), and the end of the window (1/s), infinite where all of a disc is wanted.
    negligible
        Value of abs(theta * shift) below which eigenvalues count as infinite.
    """

    damped, negligible = False, 1e-10

    def __init__(
        self,
        matrices: Matrices,
        shift: float,
        scale: float,
        reach: float = np.inf,
        decay: float = np.inf,
    ) -> None:
        self.matrices, self.shift, self.scale = matrices, shift, scale
        self.reach, self._decay, self._transposed = reach, decay, False
        self.factors = self._factorised()
        self.comm = matrices.stiffness.comm
        self.rank, self.symmetric = self.comm.rank, matrices.symmetric
        self.rows, self.finite = matrices.size, matrices.size - matrices.tied
        self.local = matrices.stiffness.getLocalSize()[0]

    def _factorised(self) -> Shifted:
        return Shifted(self.matrices, self.shift)

    def apply(self, _: Floats, image: Floats) -> Floats:
        """Return OP times a block, whose product with M is ``image``."""
        return self.factors.solve_with_forces(image, transposed=self._transposed)[0]

    def image(self, block: Floats) -> Floats:
        """Return the matrix of the inner product times a block."""
        return times(self.matrices.mass, block)

    def inner(self, left: Floats, right: Floats) -> Floats:
        """Return inner products of every column of one block with every column of another."""
        return np.asarray(all_inner(left, right, self.comm))

    def outside(self, theta: Complexes, errors: Floats) -> NDArray[np.bool_]:
        """Return which theta lie outside the window by more than errors of their eigenvalues."""
        with np.errstate(divide="ignore", invalid="ignore"):
            kappa = self.shift + 1 / theta
        return outside_of_window(upper_end(self.reach**2), kappa, errors)

    def square(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return lambda^2 of eigenvalues."""
        return -values

    def distance(self, values: NDArray[Any]) -> Floats:
        """Return the factor that makes the norm of (K - sigma M)^-1 r a backward error."""
        return np.abs(values - self.shift)

    def inverse_step(
        self, values: NDArray[Any], x: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Apply one step of inverse iteration; return displacements, scaled as x, and forces."""
        inertia = times(self.matrices.mass, x * (values - self.shift))
        return self.factors.solve_with_forces(inertia, transposed=transposed)

    def left_out(self, basis: Floats, mixed: NDArray[Any], moved: NDArray[Any]) -> NDArray[Any]:
        """Return the residual of left vectors in the subspace, W = Q - A^-T M Q (R - sigma)^T.

        It is computed for combinations ``mixed`` of its columns; ``moved`` is (R - sigma)^T mixed.
        """
        load = times(self.matrices.mass, combined(basis, moved))
        return combined(basis, mixed) - self.factors.solve_block(load, transposed=True)

    def pairing(
        self, values: Complexes, left: Complexes, right: Complexes
    ) -> tuple[Complexes, Complexes]:
        """Return Y^H M X, and the diagonal that normalised left vectors give."""
        inertia = all_inner(left, times(self.matrices.mass, right), self.comm)
        return inertia, np.ones(len(values), dtype=complex)

    def transposed(self) -> Self:
        """Return the operator of the transposed pencil, whose eigenvectors are conjugate left ones.

        It shares the factors.
        """
        other = copy(self)
        other._transposed, other.reach, other._decay = True, np.inf, np.inf
        return other

    def free(self) -> None:
        """Free the factors."""
        self.factors.free()


class Companion(ShiftInvert):
    """Inverse of the companion form at a real shift; each rank holds its rows of x, then of z.

    The window holds eigenvalues down to a decay rate (1/s).
    """

    damped, negligible = True, 1e-6

    def __init__(self, matrices: Matrices, *places: float) -> None:
        super().__init__(matrices, *places)
        self.symmetric = False
        self.rows, self.finite, self.local = 2 * self.rows, 2 * self.finite, 2 * self.local

    def _factorised(self) -> Shifted:
        return Shifted.quadratic(self.matrices, self.shift)

    def apply(self, block: Floats, image: Floats) -> Floats:
        """Return OP times a block [a; b], whose image is [M a; M b]."""
        rows, back = len(block) // 2, self._transposed
        load = -(self.scale * image[rows:] + self.shift * image[:rows])
        load -= self.matrices.drag(block[:rows], transposed=back)
        x, _ = self.factors.solve_with_forces(load, transposed=back)
        return np.asfortranarray(np.vstack([x, (block[:rows] + self.shift * x) / self.scale]))

    def image(self, block: Floats) -> Floats:
        """Return [M a; M b] of a block [a; b]."""
        rows = len(block) // 2
        halves = [super(Companion, self).image(part) for part in (block[:rows], block[rows:])]
        return np.asfortranarray(np.vstack(halves))

    def outside(self, theta: Complexes, errors: Floats) -> NDArray[np.bool_]:
        """Return which theta lie outside the window and its conjugate by more than their errors."""
        with np.errstate(divide="ignore", invalid="ignore"):
            values = self.shift + 1 / theta
        fast = np.abs(values.imag) - errors > (1 + MARGIN) * self.reach
        return np.asarray(fast | (values.real + errors < -self._decay))

    def square(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return lambda^2 of eigenvalues."""
        return values**2

    def distance(self, values: NDArray[Any]) -> Floats:
        """Return the factor that makes the norm of P(s)^-1 r a backward error.

        The z of that vector is s / g times its x.
        """
        return np.asarray(np.abs(values - self.shift) * np.hypot(1.0, self.shift / self.scale))

    def inverse_step(
        self, values: NDArray[Any], x: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Solve P(s) x' + L^T f = (s - lambda) ((lambda + s) M + D) x = (P(s) - P(lambda)) x."""
        load = times(self.matrices.mass, x * (values + self.shift))
        load += self.matrices.drag(x, transposed=transposed)
        return self.factors.solve_with_forces(load * (self.shift - values), transposed=transposed)

    def left_out(self, basis: Floats, mixed: NDArray[Any], moved: NDArray[Any]) -> NDArray[Any]:
        """Return the residual of the second halves z = y of left vectors, by the adjoint of OP."""
        rows, scale = len(basis) // 2, self.scale
        whole = combined(basis, moved)
        load = times(self.matrices.mass, whole[:rows] + self.shift / scale * whole[rows:])
        w = self.factors.solve_block(np.asfortranarray(load), transposed=True)
        return combined(basis[rows:], mixed) + scale * w

    def pairing(
        self, values: Complexes, left: Complexes, right: Complexes
    ) -> tuple[Complexes, Complexes]:
        """Return Y^H ((lambda_i + lambda_j) M + D) X, and 2 lambda."""
        inertia, _ = super().pairing(values, left, right)
        drag = all_inner(left, self.matrices.drag(right), self.comm)
        return (values[:, None] + values) * inertia + drag, 2 * values
