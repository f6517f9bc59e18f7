"""What a pencil makes of displacements and contact forces, and how large the parts of it are."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.blocks import image_of, times, transposed_times
from cea.eigen.pencil import Matrices
from cea.eigen.quadratic_damping import Damping
from cea.matrices import absolute, destroy


def internal_forces(
    matrices: Matrices, x: NDArray[Any], f: NDArray[Any], *, transposed: bool = False
) -> NDArray[Any]:
    """K x + L^T f, or K^T x + J^T f, of displacements and contact forces, in blocks of columns."""
    force = times(matrices.stiffness, x)
    if matrices.unsymmetric is not None:
        force += (transposed_times if transposed else times)(matrices.unsymmetric, x)
    if matrices.circulatory is not None:
        force += matrices.circulatory.times(x, transposed=transposed)
    if (forces := matrices.multipliers) is not None:
        force += transposed_times(forces.closure if transposed else forces.reaction, f)
    return force


class Sizes:
    """Absolute values of the entries of a pencil: what rounding them comes to.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    damping
        What multiplies lambda; None where that is left out.
    """

    def __init__(self, matrices: Matrices, damping: Damping | None = None) -> None:
        stiffness = (matrices.stiffness, matrices.unsymmetric)
        self._stiffness = [absolute(each) for each in stiffness if each is not None]
        self._mass = None if matrices.mass is None else absolute(matrices.mass)
        self._damping, self._circulatory = damping, matrices.circulatory
        forces = matrices.multipliers
        self._reaction = None if forces is None else absolute(forces.reaction)

    def forces(
        self, x: NDArray[Any], f: NDArray[Any], values: NDArray[Any] | float = 0.0
    ) -> Floats:
        """What the parts of P(lambda) [x; f] come to, the rows of this rank.

        Parameters
        ----------
        x, f
            Displacements and contact forces, the rows of this rank, shapes (n_local, columns) and
            (multipliers of this rank, columns).
        values
            lambda (1/s), shape (columns,).
        """
        size, speed = np.abs(x), np.abs(values)
        total = np.zeros(size.shape, order="F")
        for part in self._stiffness:
            total += image_of(part, size)
        if self._circulatory is not None:
            total += self._circulatory.sizes(x)
        if self._reaction is not None:
            total += transposed_times(self._reaction, np.abs(f))
        if np.any(speed) and self._mass is not None:
            total += image_of(self._mass, size) * speed**2
        if np.any(speed) and self._damping is not None:
            total += self._damping.sizes(size) * speed
        return total

    def free(self) -> None:
        """Free the matrices but those of the damping."""
        others = (self._mass, self._reaction)
        destroy(*self._stiffness, *(each for each in others if each is not None))
