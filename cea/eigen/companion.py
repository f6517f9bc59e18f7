"""Block Krylov search of a quadratic problem about a shift, by its companion form.

With x, and z = lambda x / gamma beside it, (lambda^2 M + lambda D + K) x = 0, D = C + Y, is linear,

    lambda [ x ]   [        gamma z           ]
           [ z ] = [ -M^-1 (K x / gamma + D z) ],

and its inverse at a shift s takes one solve with P(s) = s^2 M + s D + K:

    OP [ a ]   [         x         ]
       [ b ] = [ (a + s x) / gamma ],     P(s) x = -(gamma M b + s M a + D a).

Vectors are real about a real shift and complex about a complex one; matrices and factors are real.
The scale gamma is the end of the window: there x and z are equally large, in an inner product that
is M for both, and residuals are backward errors.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.eigen.block_krylov import BlockSearch
from cea.eigen.blocks import times
from cea.eigen.pencil import Matrices
from cea.eigen.quadratic_damping import Damping
from cea.eigen.quadratic_shifted import QuadraticShifted
from cea.timing import StageTimer


class CompanionSearch(BlockSearch):
    """Searches of (lambda^2 M + lambda D + K) x = 0 around a shift.

    Vectors are [x; z], on each rank its rows of both.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    factors
        P(s) factorised.
    scale
        gamma (1/s).
    tolerance, max_restarts, timer
        Those of :class:`cea.eigen.block_krylov.BlockSearch`.
    most
        Eigenvalues in a disc at which it is called crowded.
    transposed
        Whether vectors of P^T are searched: conjugates of left ones.
    """

    unknown = "lambda"
    cleansing = 2

    def __init__(
        self,
        matrices: Matrices,
        factors: QuadraticShifted,
        scale: float,
        *,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
        most: int,
        transposed: bool = False,
    ) -> None:
        super().__init__(
            2 * matrices.size,
            2 * (matrices.size - matrices.tied),
            factors.shift,
            matrices.stiffness.comm.tompi4py(),
            tolerance=tolerance,
            max_restarts=max_restarts,
            timer=timer,
        )
        self._mass, self._factors, self._transposed = matrices.mass, factors, transposed
        self._scale, self.most = scale, most
        self.dtype = complex if np.iscomplexobj(factors.shift) else float
        self._damping = Damping(matrices, transposed=transposed)

    def apply(self, block: NDArray[Any], image: NDArray[Any]) -> NDArray[Any]:
        """OP on a block [a; b] whose image [M a; M b] is given."""
        rows = len(block) // 2
        load = -(self._scale * image[rows:] + self.shift * image[:rows])
        load -= self._damping.times(block[:rows])
        x, _ = self._factors.solve_with_forces(load, transposed=self._transposed)
        return np.vstack([x, (block[:rows] + self.shift * x) / self._scale])

    def image(self, block: NDArray[Any]) -> NDArray[Any]:
        """[M a; M b] of a block [a; b]."""
        rows = len(block) // 2
        both = times(self._mass, np.hstack([block[:rows], block[rows:]]))
        columns = block.shape[1]
        return np.vstack([both[:, :columns], both[:, columns:]])

    def free(self) -> None:
        """Free what is its own."""
        self._damping.free()
