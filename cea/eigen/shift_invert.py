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

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import image_of, inner
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

    Raises
    ------
    ConvergenceError
        When the pencil is singular at the shift.
    """

    powers = 1
    negligible = 1e-10

    def __init__(
        self, matrices: Matrices, shift: float, end: float, of: "Undamped | None" = None
    ) -> None:
        self.matrices, self.shift, self._end = matrices, shift, end
        self.reach = np.inf if of else end
        self.factors: Shifted = of.factors if of else self._factorised()
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

    def transposed(self) -> "Undamped":
        """The same of K^T, whose eigenvectors are left ones, of conjugate eigenvalues."""
        return type(self)(self.matrices, self.shift, self._end, self)

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
        self._damping = Damping(matrices, transposed=self._transposed)

    def _factorised(self) -> Shifted:
        return Shifted.quadratic(self.matrices, self.shift)

    def apply(self, block: Floats, image: Floats) -> Floats:
        """OP on a block [a; b] whose image [M a; M b] is given."""
        rows = len(block) // 2
        load = -(self._end * image[rows:] + self.shift * image[:rows])
        load -= self._damping.times(block[:rows])
        x = self.factors.solve_block(load, transposed=self._transposed)
        return np.asfortranarray(np.vstack([x, (block[:rows] + self.shift * x) / self._end]))

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

    def transposed(self) -> "Companion":
        """The same of P^T, whose vectors are conjugates of left ones."""
        return Companion(self.matrices, self.shift, self._end, self)

    def free(self) -> None:
        """Free what is its own."""
        self._damping.free()
        super().free()
