"""D = C + Y of a damped or rotating pencil: what multiplies lambda."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.blocks import image_of, times, transposed_times
from cea.eigen.pencil import Matrices
from cea.matrices import absolute, destroy, scaled_total
from cea.petsc import PETSc


class Damping:
    """D, a matrix and pieces of low rank.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    transposed
        Whether it is D^T.
    """

    def __init__(self, matrices: Matrices, *, transposed: bool = False) -> None:
        pieces = [m for m in (matrices.damping, matrices.gyroscopic) if m is not None]
        self._low_rank = matrices.low_rank
        self._matrix = scaled_total([(1.0, piece) for piece in pieces]) if pieces else None
        if transposed and self._matrix is not None:
            before = self._matrix
            self._matrix = before.transpose(PETSc.Mat())
            before.destroy()
        self._absolute: Any | None = None

    def times(self, x: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """D x, or D^T x, for every column, the rows of this rank."""
        if self._matrix is None:
            force = np.zeros_like(x)
        else:
            force = (transposed_times if transposed else times)(self._matrix, x)
        if self._low_rank is not None:
            force += self._low_rank.times(x)
        return force

    def sizes(self, x: Floats) -> Floats:
        """abs(D) x of displacements that are positive; of pieces of low rank, abs(W) d abs(W)^T x.

        Rounding of the entries, of W for the latter, is relative to it.
        """
        if self._matrix is not None and self._absolute is None:
            self._absolute = absolute(self._matrix)
        force = np.zeros_like(x) if self._absolute is None else image_of(self._absolute, x)
        if self._low_rank is not None:
            force += self._low_rank.sizes(x)
        return force

    def free(self) -> None:
        """Free the matrices."""
        destroy(*(matrix for matrix in (self._matrix, self._absolute) if matrix is not None))
