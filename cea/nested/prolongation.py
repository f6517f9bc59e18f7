"""Displacements of a coarse discretisation among the unknowns of a finer one.

A backend gives the coefficients on all scalar dofs of a body; supports are taken out here. With Z
the expansion of the coarse body, and B the frames in which the fine one is free
(:meth:`cea.supports.constraints.Constraints.frames`),

    P = B^T (p x I) Z,

p the prolongation of scalar functions. Contact forces that are unknowns are no part of it: they
follow from displacements.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array, kron

from cea.arrays import Floats
from cea.body import Body
from cea.body.body import free_operator
from cea.errors import InputError
from cea.matrices import applied, block_diagonal, destroy, identity
from cea.petsc import MPI


@dataclass(frozen=True)
class Prolongation:
    """From the free dofs of a coarse discretisation to those of a finer one: a PETSc AIJ matrix.

    The defect is the largest difference that was found between a coarse function and its
    prolongation, relative to its coefficients; what supports hold differently is part of it.
    """

    matrix: Any
    defect: float

    def free(self) -> None:
        """Free the matrix."""
        destroy(self.matrix)


def of_body(coarse: Body, fine: Body) -> Prolongation:
    """Prolongation of one body between what supports leave free; collective.

    Discretisations on different backends, or not of one body, are refused.
    """
    if coarse is fine:
        return Prolongation(identity(fine.expansion.getLocalSize()[1], fine.comm), 0.0)
    kinds = type(coarse.space), type(fine.space)
    if kinds[0] is not kinds[1]:
        names = tuple(kind.__name__ for kind in kinds)
        allowed = "one backend for both discretisations"
        raise InputError(f"bodies.{fine.name}.backend", names, allowed)
    scalar, defect = fine.space.prolongation(coarse.space)
    first, last = (row // fine.dim for row in fine.expansion.getOwnershipRange())
    full = csr_array(kron(scalar, eye_array(fine.dim), format="csr"))
    frames = fine.constraints.frames(first, last)
    matrix = free_operator(csr_array(frames.T @ full), coarse)
    held = _held_differently(matrix, full, coarse, fine)
    return Prolongation(matrix, fine.comm.allreduce(max(defect, held), op=MPI.MAX))


def of_system(parts: Sequence[Prolongation]) -> Prolongation:
    """Prolongation of the unknowns of a system from those of its bodies, in their order."""
    defect = max(part.defect for part in parts)
    if len(parts) == 1:
        return Prolongation(parts[0].matrix, defect)
    whole = block_diagonal([part.matrix for part in parts]).convert("aij")
    destroy(*(part.matrix for part in parts))
    return Prolongation(whole, defect)


def varied_coefficients(count: int) -> Floats:
    """Coefficients from -1 to 1 that a defect is measured with, the same on every rank."""
    return np.sin(np.arange(1.0, count + 1) ** 2)


def _held_differently(matrix: Any, full: csr_array, coarse: Body, fine: Body) -> float:
    """Difference that fine supports make to a displacement that the coarse ones admit."""
    own = slice(*coarse.expansion.getOwnershipRangeColumn())
    v = varied_coefficients(coarse.expansion.getSize()[1])[own]
    wanted = full @ np.concatenate(coarse.comm.allgather(applied(coarse.expansion, v)))
    found = applied(fine.expansion, applied(matrix, v))
    return float(np.abs(found - wanted).max(initial=0.0))
