"""Contact in the saddle form: its forces are unknowns beside the displacements.

With p = P p^ and the QR factorisation sqrt(W p^) G = Q J,

    [ K   L^T  ] [x]   [r]
    [ J   -1/P ] [f] = [0],     L = J - Q^T sqrt(W p^) diag(mu) T,

and eliminating f gives the penalty form: P L^T J = K_n - K_f. No digits are lost to rounding as P
grows, and P = infinity ties the sides along the normal while friction stays alive. A rule has more
points than there are independent gaps; a pivoted factorisation drops the rest, so that no more
multipliers remain than sides a and b have dofs.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array, vstack

from cea.body import Floats, Ints
from cea.contact.interface import local_rows
from cea.contact.operators import Contact
from cea.matrices import distributed

_DEPENDENT = 1e-12
"""Rows of J whose pivot is below this part of the largest are dropped."""
_CHUNK_BYTES = 64 * 2**20


@dataclass(frozen=True)
class Multipliers:
    """Contact forces as unknowns: K x + L^T f = r, J x - C f = 0.

    Parameters
    ----------
    closure
        J, PETSc AIJ (multipliers x free dofs).
    reaction
        L, PETSc AIJ (multipliers x free dofs); the same object as J without friction.
    compliance
        Diagonal of C = 1/P (m/N), PETSc vector (multipliers); zero where the sides are tied.
    """

    closure: Any
    reaction: Any
    compliance: Any

    @property
    def symmetric(self) -> bool:
        """True without friction."""
        return self.reaction is self.closure

    @property
    def size(self) -> int:
        """Number of multipliers."""
        return int(self.closure.getSize()[0])


def multipliers_of(contacts: Sequence[Contact]) -> Multipliers | None:
    """Multipliers of the contacts in the saddle form; None where there are none.

    The halves of a full pass are compressed together: their gaps depend on each other.
    """
    pairs: dict[str, list[Contact]] = {}
    for contact in contacts:
        if contact.law.form == "saddle":
            pairs.setdefault(contact.pair, []).append(contact)
    if not pairs:
        return None
    closures, reactions, compliances = [], [], []
    for halves in pairs.values():
        closure, reaction = _compressed(halves)
        closures.append(closure)
        reactions.append(reaction)
        compliances.append(np.full(closure.shape[0], 1 / halves[0].scale))
    template = next(iter(pairs.values()))[0].gap
    frictional = any(c.slip is not None for halves in pairs.values() for c in halves)
    closure = _shared_out(csr_array(vstack(closures)), template)
    reaction = _shared_out(csr_array(vstack(reactions)), template) if frictional else closure
    compliance = closure.createVecLeft()
    compliance.array[:] = np.concatenate(compliances)[slice(*compliance.getOwnershipRange())]
    return Multipliers(closure, reaction, compliance)


def _compressed(halves: Sequence[Contact]) -> tuple[csr_array, csr_array]:
    """J and L of one contact, all their rows on every rank.

    Rows go through the factorisation a chunk at a time, each on top of the triangle left by those
    before it; the last factorisation is pivoted.
    """
    gap = csr_array(vstack([_weighted(half, half.gap) for half in halves]))
    slip = csr_array(vstack([_weighted(half, half.slip) for half in halves]))
    columns = np.unique(np.concatenate([gap.indices, slip.indices])).astype(np.int64)
    triangle = projected = np.empty((0, len(columns)))
    for rows in _chunks(gap.shape[0], len(columns)):
        q, triangle = np.linalg.qr(np.vstack([triangle, gap[rows][:, columns].toarray()]))
        projected = q.T @ np.vstack([projected, slip[rows][:, columns].toarray()])
    q, pivoted, order = qr(triangle, pivoting=True, mode="economic")
    pivots = np.abs(np.diag(pivoted))
    kept = pivots > _DEPENDENT * pivots[0]
    closure = np.empty((int(kept.sum()), len(columns)))
    closure[:, order] = pivoted[kept]
    reaction = closure - q[:, kept].T @ projected
    size = gap.shape[1]
    return _spread(closure, columns, size), _spread(reaction, columns, size)


def _weighted(half: Contact, operator: Any | None) -> csr_array:
    """sqrt(W p^) G or T, all rows on every rank; zero where there is no such operator."""
    if operator is None:
        return csr_array(half.gap.getSize())
    start, stop = operator.getOwnershipRange()
    indptr, indices, values = operator.getValuesCSR()
    local = csr_array((values, indices, indptr), shape=(stop - start, operator.getSize()[1]))
    root = np.sqrt(half.weight.array)
    scaled = csr_array(local.multiply(root[:, None]))
    scaled.eliminate_zeros()
    return csr_array(vstack(half.interface.comm.allgather(scaled)))


def _chunks(rows: int, columns: int) -> Iterator[slice]:
    step = max(columns, _CHUNK_BYTES // (8 * max(columns, 1)), 1)
    for start in range(0, rows, step):
        yield slice(start, start + step)


def _spread(block: Floats, columns: Ints, size: int) -> csr_array:
    """Dense columns in their places."""
    indptr = np.arange(len(block) + 1, dtype=np.int64) * len(columns)
    matrix = csr_array(
        (block.ravel(), np.tile(columns, len(block)), indptr), shape=(len(block), size)
    )
    matrix.eliminate_zeros()
    return matrix


def _shared_out(matrix: csr_array, template: Any) -> Any:
    """Rows shared out evenly, columns as those of the template."""
    start, stop = local_rows(matrix.shape[0], template.comm.tompi4py())
    return distributed(csr_array(matrix[start:stop]), template.getSizes()[1], template.comm)
