"""The energy norm of a map: that of the symmetric stiffness where it is softest.

    X = S(t0) + s M(t0)

with every parameter at its least value: K(t) is no softer in any direction while friction is left
aside. Residuals are measured in the norm of X^-1. The shift s, a hundredth of omega^2 of the
window, keeps X definite where bodies float.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.blocks import column_blocks, image_of
from cea.eigen.multipliers import AllForces, ForcesOfContact
from cea.eigen.pencil import Matrices, Pencil
from cea.eigen.shifted import Shifted
from cea.eigen.spectrum import SLOW
from cea.errors import ConvergenceError
from cea.matrices import destroy, scaled_total

_FEW = 0.3
"""Part of all displacements up to which products with the others are left out."""


def shift_of(max_frequency: float) -> float:
    """Shift s (1/s^2) of the norm for a window (Hz)."""
    return (SLOW * 2 * np.pi * max_frequency) ** 2


class InnerProduct:
    """What bases are orthonormal in: ``image`` is its matrix times a block of this rank's rows."""

    def __init__(self, comm: Any, rows: int, image: Callable[[Floats], Floats]) -> None:
        self.comm, self.rows, self.image = comm, rows, image

    def held(self, block: Floats) -> Floats:
        """Vectors that obey constraints, where there are any."""
        return block

    def inner(self, left: Floats, right: Floats) -> Floats:
        """L^T R, shape (columns of L, columns of R), the same on every rank.

        Forces of a contact act on few displacements: the others are left out.
        """
        rows = np.flatnonzero(right.any(axis=1))
        if len(rows) < _FEW * len(right):
            left, right = left[rows], right[rows]
        return self.comm.bcast(self.comm.allreduce(left.T @ right))

    def lengths(self, block: Floats, image: Floats | None = None) -> Floats:
        """X-norms of the columns of a block, whose image may be known, the same on every rank."""
        image = self.image(block) if image is None else image
        squares = self.comm.allreduce(np.einsum("ij,ij->j", block, image))
        return np.sqrt(np.maximum(self.comm.bcast(squares), 0.0))

    @staticmethod
    def principal(products: Floats, floor: float = 0.0) -> tuple[Floats, Floats]:
        """Eigenvalues and vectors of W^T X W; below the square of a length it may be rounding.

        Raises ConvergenceError when X is not positive definite.
        """
        sizes, axes = np.linalg.eigh(0.5 * (products + products.T))
        if len(sizes) and sizes[0] < -max(1e-6 * sizes[-1], floor**2):
            raise ConvergenceError("the stiffness at the least parameters is not positive definite")
        return sizes, axes


class EnergyNorm(InnerProduct):
    """X at some values of all parameters, factorised; tied sides are constraints of all vectors.

    Raises ConvergenceError when X is singular.
    """

    def __init__(
        self,
        pencil: Pencil,
        values: Mapping[str, float],
        tied: tuple[ForcesOfContact, ...],
        max_frequency: float,
    ) -> None:
        self.shift = shift_of(max_frequency)
        parts = []
        for term in pencil.terms:
            if term.symmetric and term.role in ("stiffness", "mass"):
                weight = term.coefficient.at(values) * (self.shift if term.role == "mass" else 1.0)
                parts.append((weight, term.matrix))
        self._matrix = scaled_total([part for part in parts if part[0]])
        self._matrix.setOption(self._matrix.Option.SYMMETRIC, True)
        self._forces = AllForces(tied).at(values) if tied else None
        self._factors = Shifted(Matrices(self._matrix, None, None, self._forces))
        super().__init__(pencil.comm.tompi4py(), self._matrix.getLocalSize()[0], self._image)

    def _image(self, block: Floats) -> Floats:
        """X times a block of vectors."""
        image = np.empty_like(block)
        for columns in column_blocks(block.shape[1]):
            image[:, columns] = image_of(self._matrix, block[:, columns])
        return image

    def solve(self, block: Floats) -> Floats:
        """X^-1 times a block of forces."""
        solution = np.empty_like(block)
        for columns in column_blocks(block.shape[1]):
            solution[:, columns] = self._factors.solve_block(block[:, columns])
        return solution

    def held(self, block: Floats) -> Floats:
        """Vectors that obey the ties but for rounding, which grows as they are made longer."""
        return block if self._forces is None else self.solve(self.image(block))

    def free(self) -> None:
        """Free the factors."""
        self._factors.free()
        destroy(self._matrix)
        if self._forces is not None:
            self._forces.free()
