"""What a pencil makes of displacements and contact forces, and how large the parts of it are."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.blocks import image_of, times, transposed_times
from cea.eigen.pencil import Matrices
from cea.matrices import absolute, destroy, scaled_total


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


class Damping:
    """D = C + Y of a pencil at given parameters: a matrix and pieces of low rank."""

    def __init__(self, matrices: Matrices) -> None:
        pieces = [m for m in (matrices.damping, matrices.gyroscopic) if m is not None]
        self._low_rank, self._comm = matrices.low_rank, matrices.mass.comm
        self._matrix = scaled_total([(1.0, piece) for piece in pieces]) if pieces else None
        self._absolute: Any | None = None

    def times(self, x: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """D x, or D^T x, for every column, the rows of this rank."""
        product = transposed_times if transposed else times
        force = np.zeros_like(x) if self._matrix is None else product(self._matrix, x)
        if self._low_rank is not None:
            force += self._low_rank.times(x, self._comm)
        return force

    def sizes(self, x: Floats) -> Floats:
        """abs(D) x of displacements that are positive; of low rank abs(W) d abs(W)^T x."""
        if self._matrix is not None and self._absolute is None:
            self._absolute = absolute(self._matrix)
        force = np.zeros_like(x) if self._absolute is None else image_of(self._absolute, x)
        if self._low_rank is not None:
            force += self._low_rank.sizes(x, self._comm)
        return force

    def free(self) -> None:
        """Free the matrices."""
        destroy(*(matrix for matrix in (self._matrix, self._absolute) if matrix is not None))


class Sizes:
    """Absolute values of the entries of a pencil, of D where it is given: rounding is of them."""

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
        """What the parts of P(lambda) [x; f] come to, the rows of this rank, shape (n_local, n)."""
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
