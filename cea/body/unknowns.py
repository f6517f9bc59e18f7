"""Operators on full dofs of bodies as operators on the unknowns of a system.

On every rank the unknowns are the free dofs of the first body, then those of the second, and so on.
"""

from collections.abc import Mapping
from typing import Any

from scipy.sparse import csr_array

from cea.body.body import Body
from cea.matrices import destroy, distributed, side_by_side, times, zeros
from cea.petsc import PETSc


def free_operator(operator: csr_array, body: Body) -> Any:
    """An operator on full dofs, the rows of this rank, on free dofs: A Z, PETSc AIJ."""
    full = distributed(operator, body.expansion.getSizes()[0], body.comm)
    free = times(full, body.expansion)
    destroy(full)
    return free


def system_operator(bodies: Mapping[str, Body], parts: Mapping[str, csr_array], rows: int) -> Any:
    """Operators on full dofs of some bodies as one on the unknowns of the whole system."""
    blocks = [
        free_operator(parts[name], body)
        if name in parts
        else zeros((rows, PETSc.DETERMINE), body.expansion.getSizes()[1], body.comm)
        for name, body in bodies.items()
    ]
    whole = side_by_side(blocks)
    destroy(*blocks)
    return whole
