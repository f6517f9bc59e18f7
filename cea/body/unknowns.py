"""Operators on full dofs of bodies as operators on the unknowns of a system.

On every rank the unknowns are the free dofs of the first body, then those of the second, and so on.
Contacts touch few dofs: only these rows of an expansion are looked at.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.sparse import csr_array, hstack

from cea.arrays import Ints
from cea.body.body import Body
from cea.matrices import destroy, distributed, local_part
from cea.petsc import PETSc


def free_operator(operator: csr_array, body: Body) -> Any:
    """Restrict an operator on full dofs, distributed by rows, to free dofs."""
    free = _on_free_dofs(operator, body.expansion)
    return distributed(_rising(free), body.expansion.getSizes()[1], body.comm)


def system_operator(bodies: Mapping[str, Body], parts: Mapping[str, csr_array], rows: int) -> Any:
    """Operators on full dofs of some bodies as one on the unknowns of the whole system."""
    expansions = [body.expansion for body in bodies.values()]
    blocks = [
        _on_free_dofs(parts[name], expansion) if name in parts else _on_nothing(rows, expansion)
        for name, expansion in zip(bodies, expansions, strict=True)
    ]
    whole = csr_array(hstack(blocks, format="csr"))
    sizes = np.array([np.diff(expansion.getOwnershipRangesColumn()) for expansion in expansions])
    comm = next(iter(bodies.values())).comm
    whole.indices = _numbered(whole.indices, sizes)
    own = int(sizes[:, comm.rank].sum())
    return distributed(_rising(whole), (own, int(sizes.sum())), comm, shared=True)


def _on_nothing(rows: int, expansion: Any) -> csr_array:
    """No columns of a body that an operator does not touch."""
    return csr_array((rows, expansion.getSize()[1]))


def _on_free_dofs(operator: csr_array, expansion: Any) -> csr_array:
    """Operator times expansion, the rows of this rank; collective."""
    touched = np.zeros(operator.shape[1], dtype=bool)
    touched[operator.indices] = True
    dofs = np.flatnonzero(touched)
    rows = _rows(expansion, dofs)
    place = np.zeros(operator.shape[1], dtype=operator.indices.dtype)
    place[dofs] = np.arange(len(dofs))
    narrow = (operator.data, place[operator.indices], operator.indptr)
    return csr_array(csr_array(narrow, (operator.shape[0], len(dofs))) @ rows)


def _rows(matrix: Any, rows: Ints) -> csr_array:
    """Some rows, of whichever ranks, of a PETSc AIJ matrix; collective."""
    columns = matrix.getSize()[1]
    if matrix.comm.size == 1:
        return csr_array(local_part(matrix)[rows])
    numbers: Any = rows.astype(PETSc.IntType)
    chosen = PETSc.IS().createGeneral(numbers, comm=PETSc.COMM_SELF)
    every = PETSc.IS().createStride(columns, comm=PETSc.COMM_SELF)
    (part,) = matrix.createSubMatrices(chosen, every)
    result = local_part(part)
    destroy(chosen, every, part)
    return result


def _numbered(columns: Any, sizes: Ints) -> Any:
    """Free dofs of one body after another as unknowns, which go from rank to rank."""
    if sizes.shape[1] == 1:
        return columns
    ends = np.cumsum(sizes)
    before = np.cumsum(sizes.T).reshape(sizes.T.shape).T - sizes
    shift = before.ravel() - (ends - sizes.ravel())
    return columns + shift[np.searchsorted(ends, columns, side="right")].astype(columns.dtype)


def _rising(matrix: csr_array) -> csr_array:
    """The same with the columns of each row rising."""
    # A new one looks at its columns before it sorts them.
    parts = (matrix.data, matrix.indices, matrix.indptr)
    risen = csr_array(parts, shape=matrix.shape)
    risen.sort_indices()
    return risen
