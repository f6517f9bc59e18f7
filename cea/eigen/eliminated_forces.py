"""What contact forces that are unknowns make of the stiffness, were they eliminated.

With f = C^-1 J x they add L^T C^-1 J to K. Of M = (J + L) / 2 and D = (J - L) / 2, which friction
makes, its symmetric part is M^T C^-1 M - D^T C^-1 D and its skew part M^T C^-1 D - D^T C^-1 M. They
are full matrices on the interface and never formed.
"""

from typing import Any

from cea.arrays import Floats
from cea.eigen.blocks import times, transposed_times
from cea.eigen.multipliers import Multipliers
from cea.eigen.mumps import Mumps
from cea.matrices import destroy
from cea.petsc import Mat, PETSc


def mean_and_half(forces: Multipliers) -> tuple[Mat, Mat]:
    """M = (J + L) / 2 and D = (J - L) / 2, new matrices."""
    mean, half = forces.closure.copy(), forces.closure.copy()
    pattern: Any = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN
    mean.axpy(1.0, forces.reaction, structure=pattern)
    half.axpy(-1.0, forces.reaction, structure=pattern)
    mean.scale(0.5)
    half.scale(0.5)
    return mean, half


class EliminatedForces:
    """Symmetric and skew part of L^T C^-1 J, for blocks of vectors.

    Parameters
    ----------
    forces
        Contact forces, all of which have compliance and closures of their own.

    Raises
    ------
    ConvergenceError
        When their compliance is singular.
    """

    def __init__(self, forces: Multipliers) -> None:
        self._mean, self._half = mean_and_half(forces)
        self._compliance = Mumps(forces.compliance.copy(), symmetric=True)

    @staticmethod
    def possible(forces: Multipliers) -> bool:
        """Whether forces can be eliminated: none is tied, none depends on others."""
        return not forces.tied and forces.border is None

    def symmetric(self, x: Floats) -> Floats:
        """(M^T C^-1 M - D^T C^-1 D) x, the rows of this rank."""
        pressed, rubbed = self._forces(x)
        return transposed_times(self._mean, pressed) - transposed_times(self._half, rubbed)

    def skew(self, x: Floats) -> Floats:
        """(M^T C^-1 D - D^T C^-1 M) x, the rows of this rank."""
        pressed, rubbed = self._forces(x)
        return transposed_times(self._mean, rubbed) - transposed_times(self._half, pressed)

    def _forces(self, x: Floats) -> tuple[Floats, Floats]:
        """C^-1 M x and C^-1 D x."""
        pressed, rubbed = (
            self._compliance.solve_block(times(matrix, x)) for matrix in (self._mean, self._half)
        )
        return pressed, rubbed

    def free(self) -> None:
        """Free its matrices and factors."""
        self._compliance.free()
        destroy(self._mean, self._half)
