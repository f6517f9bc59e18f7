"""Prolongation of displacements from a coarse discretisation to the unknowns of a finer one.

A backend gives the prolongation p of scalar functions on all dofs; supports are eliminated here.
With the expansion Z of free dofs of the coarse body to all dofs, and the frames B of the free dofs
of the fine body (:meth:`cea.supports.constraints.Constraints.frames`),

    P = B^T (p x I) Z.

Contact forces are not prolonged: they follow from displacements.
"""

from collections.abc import Sequence
from typing import Any

from scipy.sparse import csr_array, eye_array, kron

from cea.body import Body, free_operator
from cea.errors import InputError
from cea.matrices import block_diagonal, destroy, identity


def of_body(coarse: Body, fine: Body) -> Any:
    """Return the prolongation between the free dofs of one body, PETSc AIJ; collective.

    Discretisations on different backends or of different bodies are refused.
    """
    if coarse is fine:
        return identity(fine.expansion.getLocalSize()[1], fine.comm)
    kinds = type(coarse.space), type(fine.space)
    if kinds[0] is not kinds[1]:
        names = tuple(kind.__name__ for kind in kinds)
        allowed = "one backend for both discretisations"
        raise InputError(f"bodies.{fine.name}.backend", names, allowed)
    scalar = fine.space.prolongation(coarse.space)
    first, last = (row // fine.dim for row in fine.expansion.getOwnershipRange())
    full = csr_array(kron(scalar, eye_array(fine.dim), format="csr"))
    frames = fine.constraints.frames(first, last)
    return free_operator(csr_array(frames.T @ full), coarse)


def of_system(parts: Sequence[Any]) -> Any:
    """Return the prolongation of a system: block diagonal, in the order of its bodies."""
    if len(parts) == 1:
        return parts[0]
    whole = block_diagonal(list(parts)).convert("aij")
    destroy(*parts)
    return whole
