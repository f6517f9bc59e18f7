"""How large the parts are whose sums a pencil makes: what rounding their entries comes to."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.blocks import image_of, transposed_times
from cea.eigen.pencil import Matrices
from cea.matrices import absolute, destroy


class Sizes:
    """Absolute values of a pencil's stiffness.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    """

    def __init__(self, matrices: Matrices) -> None:
        self._stiffness = [absolute(matrices.stiffness)]
        if matrices.unsymmetric is not None:
            self._stiffness.append(absolute(matrices.unsymmetric))
        self._reaction = None
        if matrices.multipliers is not None:
            self._reaction = absolute(matrices.multipliers.reaction)
        self._comm = matrices.stiffness.comm

    def forces(self, x: Floats, f: Floats) -> Floats:
        """abs(K) x + abs(L)^T f of displacements and contact forces that are positive.

        Parameters
        ----------
        x, f
            The rows of this rank, shapes (n_local, columns) and (multipliers of this rank,
            columns).
        """
        total = np.zeros_like(x)
        for part in self._stiffness:
            total += image_of(part, x)
        if self._reaction is not None:
            total += transposed_times(self._reaction, f)
        return total

    def works(self, x: NDArray[Any], f: NDArray[Any]) -> Floats:
        """abs(x)^T abs(K) abs(x), what the parts of x^H K x come to, by column."""
        size = np.abs(x)
        parts = np.einsum("ij,ij->j", size, self.forces(size, 2 * np.abs(f)))
        return self._comm.tompi4py().allreduce(parts)

    def free(self) -> None:
        """Free the matrices."""
        destroy(*self._stiffness, *([self._reaction] if self._reaction is not None else []))
