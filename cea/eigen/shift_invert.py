"""Shift-and-invert operators: what a search needs of a factorised pencil.

Without damping K x = kappa M x, and about a shift sigma

    OP = (K - sigma M)^-1 M,    theta = 1 / (kappa - sigma).

With x, and z = lambda x / g beside it, (lambda^2 M + lambda D + K) x = 0, D = C + Y, is linear too,

    lambda [ x ]   [        g z           ]
           [ z ] = [ -M^-1 (K x / g + D z) ],

and its inverse at a real shift s takes one solve with P(s) = s^2 M + s D + K:

    OP [ a ]   [       x         ]
       [ b ] = [ (a + s x) / g ],     P(s) x = -(g M b + s M a + D a).

The scale g is the end of the window: there x and z are equally large, in an inner product that is
M for both, and residuals are backward errors. All of it is real.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import all_inner, combined, image_of, inner, times
from cea.eigen.coverage import outside_of_window, upper_end
from cea.eigen.pencil import Matrices
from cea.eigen.quadratic_damping import Damping
from cea.eigen.shifted import Shifted

MARGIN = 0.005
"""What is covered beyond both ends of a damped window relative to omega: room between the window
and the first mode beyond it, and conjugates of those next to the real axis."""


class Undamped:
    """(K - sigma M)^-1 M; attributes are those of :class:`cea.eigen.krylov_space.ShiftInvert`.

    ``reach`` is the end of the window (1/s); infinite where all of a disc is wanted, as it is of
    left eigenvectors.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    shift
        sigma (1/s^2).
    end
        omega of the end of the window (1/s).
    of
        The operator whose factors are taken, with the transposed matrix.
    factors
        The pencil factorised at the shift, where it is.

    Raises
    ------
    ConvergenceError
        When the pencil is singular at the shift.
    """

    damped = False
    damping: Damping | None = None
    powers = 1
    negligible = 1e-10

    def __init__(
        self,
        matrices: Matrices,
        shift: float,
        end: float,
        of: "Undamped | None" = None,
        *,
        factors: Shifted | None = None,
    ) -> None:
        self.matrices, self.shift, self.scale = matrices, shift, end
        self.reach = np.inf if of else end
        self.factors: Shifted = factors or (of.factors if of else self._factorised())
        self._transposed = of is not None
        self.comm = matrices.stiffness.comm.tompi4py()
        self.rank, self.symmetric = self.comm.rank, matrices.symmetric
        self.rows, self.finite = matrices.size, matrices.size - matrices.tied
        self.local = matrices.stiffness.getLocalSize()[0]

    def _factorised(self) -> Shifted:
        return Shifted(self.matrices, self.shift)

    def apply(self, _: Floats, image: Floats) -> Floats:
        """OP on a block whose product with M is given."""
        return self.factors.solve_block(image, transposed=self._transposed)

    def image(self, block: Floats) -> Floats:
        """M times a block."""
        return image_of(self.matrices.mass, block)

    def inner(self, left: Floats, right: Floats) -> Floats:
        """Inner products of every column of one block with every column of another."""
        return np.asarray(self.comm.allreduce(inner(left, right)))

    def outside(self, theta: Complexes, errors: Floats) -> NDArray[np.bool_]:
        """Which kappa lie outside of the window, whatever their growth and errors (1/s^2)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            kappa = self.shift + 1 / theta
        return outside_of_window(upper_end(self.reach**2), kappa, errors)

    def square(self, values: NDArray[Any]) -> NDArray[Any]:
        """lambda^2 of eigenvalues."""
        return -values

    def distance(self, values: NDArray[Any]) -> Floats:
        """What the length of (K - sigma M)^-1 r is multiplied by as a backward error."""
        return np.abs(values - self.shift)

    def inverse_step(
        self, values: NDArray[Any], x: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """One step of inverse iteration: displacements and contact forces, scaled as x is."""
        inertia = times(self.matrices.mass, x * (values - self.shift))
        return self.factors.solve_with_forces(inertia, transposed=transposed)

    def left_out(self, basis: Floats, mixed: NDArray[Any], moved: NDArray[Any]) -> NDArray[Any]:
        """What a subspace leaves out of its left vectors: W = Q - A^-T M Q (R - sigma)^T.

        Parameters
        ----------
        basis, mixed, moved
            Q, columns, and (R - sigma)^T times them.
        """
        load = image_of(self.matrices.mass, combined(basis, moved))
        return combined(basis, mixed) - self.factors.solve_block(load, transposed=True)

    def pairing(
        self, values: Complexes, left: Complexes, right: Complexes
    ) -> tuple[Complexes, Complexes]:
        """Y^H M X, and what its diagonal is to be; with damping as :class:`LeftVectors` has it."""
        inertia = all_inner(left, times(self.matrices.mass, right), self.matrices.mass.comm)
        return inertia, np.ones(len(values), dtype=complex)

    def transposed(self) -> "Undamped":
        """The same of K^T, whose eigenvectors are left ones, of conjugate eigenvalues."""
        return type(self)(self.matrices, self.shift, self.scale, self)

    def free(self) -> None:
        """Free the factors, but of a transposed operator."""
        if not self._transposed:
            self.factors.free()


class Companion(Undamped):
    """The inverse of the companion form at a real shift; on each rank its rows of x and z.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    shift
        s (1/s).
    end
        omega of the end of the window, and g (1/s).
    of
        The operator whose factors are taken, with the transposed matrix.
    decay
        Decay (1/s) down to which eigenvalues are of the window.
    """

    damped = True
    powers = 2
    negligible = 1e-6

    def __init__(
        self,
        matrices: Matrices,
        shift: float,
        end: float,
        of: "Undamped | None" = None,
        decay: float = np.inf,
    ) -> None:
        super().__init__(matrices, shift, end, of)
        self._decay, self.symmetric = decay, False
        self.rows, self.finite, self.local = 2 * self.rows, 2 * self.finite, 2 * self.local
        self.damping = self._drag = Damping(matrices, transposed=self._transposed)

    def _factorised(self) -> Shifted:
        return Shifted.quadratic(self.matrices, self.shift)

    def apply(self, block: Floats, image: Floats) -> Floats:
        """OP on a block [a; b] whose image [M a; M b] is given."""
        rows = len(block) // 2
        load = -(self.scale * image[rows:] + self.shift * image[:rows])
        load -= self._drag.times(block[:rows])
        x = self.factors.solve_block(load, transposed=self._transposed)
        return np.asfortranarray(np.vstack([x, (block[:rows] + self.shift * x) / self.scale]))

    def image(self, block: Floats) -> Floats:
        """[M a; M b] of a block [a; b]."""
        rows, columns = len(block) // 2, block.shape[1]
        both = image_of(self.matrices.mass, np.hstack([block[:rows], block[rows:]]))
        return np.asfortranarray(np.vstack([both[:, :columns], both[:, columns:]]))

    def outside(self, theta: Complexes, errors: Floats) -> NDArray[np.bool_]:
        """Which lambda lie outside of the window, its conjugates included, whatever their errors.

        Those that do not oscillate, and grow or decay slowly, are in it.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            values = self.shift + 1 / theta
        fast = np.abs(values.imag) - errors > (1 + MARGIN) * self.reach
        return np.asarray(fast | (values.real + errors < -self._decay))

    def square(self, values: NDArray[Any]) -> NDArray[Any]:
        """lambda^2 of eigenvalues."""
        return values**2

    def distance(self, values: NDArray[Any]) -> Floats:
        """What the length of P(s)^-1 r is multiplied by, with s / g times it in the second half."""
        return np.asarray(np.abs(values - self.shift) * np.hypot(1.0, self.shift / self.scale))

    def inverse_step(
        self, values: NDArray[Any], x: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """P(s) x' + L^T f = (s - lambda) ((lambda + s) M + D) x, which is (P(s) - P(lambda)) x."""
        load = times(self.matrices.mass, x * (values + self.shift))
        load += self._drag.times(x, transposed=transposed)
        return self.factors.solve_with_forces(load * (self.shift - values), transposed=transposed)

    def left_out(self, basis: Floats, mixed: NDArray[Any], moved: NDArray[Any]) -> NDArray[Any]:
        """The same of the z of left vectors, which are y, by the adjoint of OP."""
        rows, scale = len(basis) // 2, self.scale
        whole = combined(basis, moved)
        load = times(self.matrices.mass, whole[:rows] + self.shift / scale * whole[rows:])
        w = self.factors.solve_block(np.asfortranarray(load), transposed=True)
        return combined(basis[rows:], mixed) + scale * w

    def pairing(
        self, values: Complexes, left: Complexes, right: Complexes
    ) -> tuple[Complexes, Complexes]:
        """Y^H ((lambda_i + lambda_j) M + D) X, and 2 lambda."""
        inertia, _ = super().pairing(values, left, right)
        drag = all_inner(left, self._drag.times(right), self.matrices.mass.comm)
        return (values[:, None] + values) * inertia + drag, 2 * values

    def transposed(self) -> "Companion":
        """The same of P^T, whose vectors are conjugates of left ones."""
        return Companion(self.matrices, self.shift, self.scale, self)

    def free(self) -> None:
        """Free what is its own."""
        self._drag.free()
        super().free()
