"""Contact in the saddle form: its forces are unknowns beside the displacements.

With p = P p^ and the QR factorisation sqrt(W p^) G = Q J,

    [ K   L^T  ] [x]   [r]
    [ J   -1/P ] [f] = [0],     L = J - R,   R = Q^T sqrt(W p^) diag(mu) T,

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
class ContactForces:
    """Operators of the forces of one contact as unknowns.

    Parameters
    ----------
    closure
        J, PETSc AIJ (forces x free dofs).
    slip
        R, PETSc AIJ (forces x free dofs), of the friction that ``mu`` of its halves says; None
        without friction.
    """

    closure: Any
    slip: Any | None


def contact_forces(contacts: Sequence[Contact]) -> dict[str, ContactForces]:
    """Forces that are unknowns, by contact; none where no contact has the saddle form.

    The halves of a full pass are compressed together: their gaps depend on each other.
    """
    pairs: dict[str, list[Contact]] = {}
    for contact in contacts:
        if contact.half.form == "saddle":
            pairs.setdefault(contact.pair, []).append(contact)
    forces = {}
    for name, halves in pairs.items():
        closure, slip = _compressed(halves)
        if not closure.shape[0]:
            continue  # both sides are held: no gap can open
        template = halves[0].gap
        frictional = any(half.slip is not None for half in halves)
        forces[name] = ContactForces(
            _shared_out(closure, template), _shared_out(slip, template) if frictional else None
        )
    return forces


def _compressed(halves: Sequence[Contact]) -> tuple[csr_array, csr_array]:
    """J and R of one contact, all their rows on every rank.

    Rows go through the factorisation a chunk at a time, each on top of the triangle left by those
    before it; the last factorisation is pivoted.
    """
    shares = _shares(halves)
    gap = csr_array(
        vstack([_weighted(h, h.gap, share) for h, share in zip(halves, shares, strict=True)])
    )
    slip = csr_array(
        vstack([_weighted(h, h.slip, share) for h, share in zip(halves, shares, strict=True)])
    )
    columns = np.unique(np.concatenate([gap.indices, slip.indices])).astype(np.int64)
    triangle = projected = np.empty((0, len(columns)))
    for rows in _chunks(gap.shape[0], len(columns)):
        q, triangle = np.linalg.qr(np.vstack([triangle, gap[rows][:, columns].toarray()]))
        projected = q.T @ np.vstack([projected, slip[rows][:, columns].toarray()])
    q, pivoted, order = qr(triangle, pivoting=True, mode="economic")
    pivots = np.abs(np.diag(pivoted))
    kept = pivots > _DEPENDENT * pivots.max(initial=0.0)
    closure = np.empty((int(kept.sum()), len(columns)))
    closure[:, order] = pivoted[kept]
    size = gap.shape[1]
    return _spread(closure, columns, size), _spread(q[:, kept].T @ projected, columns, size)


def _shares(halves: Sequence[Contact]) -> list[float]:
    """Part of each half in the stiffness of the contact; equal parts where it is infinite."""
    stiffness = np.array([half.scale for half in halves])
    if np.isinf(stiffness).any():
        return [1 / len(halves)] * len(halves)
    return list(stiffness / stiffness.sum())


def _weighted(half: Contact, operator: Any | None, share: float) -> csr_array:
    """sqrt(W p^) G or T, all rows on every rank; zero where there is no such operator."""
    if operator is None:
        return csr_array(half.gap.getSize())
    start, stop = operator.getOwnershipRange()
    indptr, indices, values = operator.getValuesCSR()
    local = csr_array((values, indices, indptr), shape=(stop - start, operator.getSize()[1]))
    root = np.sqrt(share * half.weight.array)
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
