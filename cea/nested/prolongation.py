"""Displacements of a coarse discretisation among the unknowns of a finer one.

A backend gives the coefficients on all scalar dofs of a body; supports are taken out here. With Z
the expansion of the coarse body, and B the frames in which the fine one is free
(:meth:`cea.supports.constraints.Constraints.frames`),

    P = B^T (p x I) Z,

p the prolongation of scalar functions. Contact forces that are unknowns are no part of it: they
follow from displacements.
"""

from collections.abc import Sequence
from typing import Any

from scipy.sparse import csr_array, eye_array, kron

from cea.body import Body
from cea.body.body import free_operator
from cea.errors import InputError
from cea.matrices import block_diagonal, destroy, identity


def of_body(coarse: Body, fine: Body) -> Any:
    """Prolongation of one body between what supports leave free, PETSc AIJ; collective.

    Discretisations on different backends, or not of one body, are refused.
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
    """Prolongation of the unknowns of a system from those of its bodies, in their order."""
    if len(parts) == 1:
        return parts[0]
    whole = block_diagonal(list(parts)).convert("aij")
    destroy(*parts)
    return whole
