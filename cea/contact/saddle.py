"""Contact with its forces as unknowns: the saddle form, and mortar contact in either form.

    [ K   L^T  ] [x]   [r]
    [ J   -C/P ] [f] = [0],     L = J - R,

and eliminating f gives the penalty form: P L^T C^-1 J = K_n - K_f. No digits are lost to rounding
as P grows, and P = infinity ties the sides along the normal while friction stays alive. With
p = P p^,

    points:   sqrt(W p^) G = Q J,     R = Q^T sqrt(W p^) diag(mu) T,     C = 1
    mortar:   J = B,                  R = B_k,                           C_ij = int psi_i psi_j / p^

all of them sparse. A rule has more points than there are independent gaps: the factorisation drops
the rest (:mod:`cea.contact.compression`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack

from cea.arrays import Floats
from cea.contact.compression import compressed
from cea.contact.forms import squared
from cea.contact.operators import Contact
from cea.matrices import (
    block_diagonal,
    destroy,
    distributed,
    identity,
    local_part,
    one_below_the_other,
)
from cea.petsc import MPI

_UNFELT = 1e-24
"""Stiffness, relative to the largest of a contact, of a force that the bodies do not feel."""


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
    compliance
        C, PETSc AIJ (forces x forces), symmetric positive semidefinite.
    """

    closure: Any
    slip: Any | None
    compliance: Any

    def body_stiffness(self, stiffness: Any) -> tuple[float, float]:
        """P (N/m) at which its stiffest and its softest force are about as stiff as the bodies.

        Parameters
        ----------
        stiffness
            Diagonal of K of all bodies (N/m), PETSc vector.
        """
        softness, own = stiffness.duplicate(), self.closure.createVecLeft()
        stiffness.copy(softness)
        softness.reciprocal()
        squares = squared(self.closure)
        squares.mult(softness, own)
        compliance = self.compliance.getDiagonal()
        own.pointwiseDivide(own, compliance)
        comm, relative = own.comm.tompi4py(), own.array_r
        stiffest = comm.allreduce(relative.max(initial=0.0), MPI.MAX)
        felt = relative[relative > _UNFELT * stiffest]
        softest = comm.allreduce(felt.min(initial=stiffest), MPI.MIN)
        destroy(softness, own, squares, compliance)
        return 1 / stiffest, 1 / softest


def contact_forces(contacts: Sequence[Contact]) -> dict[str, ContactForces]:
    """Forces that are unknowns, by contact; none of contacts between sides that are held.

    The halves of a full pass go together: one P is shared among them.
    """
    return {
        name: (_projected if halves[0].projection is not None else _at_points)(halves)
        for name, halves in keeping_forces(contacts).items()
    }


def keeping_forces(contacts: Sequence[Contact]) -> dict[str, list[Contact]]:
    """Half passes by contact whose forces are unknowns, in the order of these."""
    pairs: dict[str, list[Contact]] = {}
    for contact in contacts:
        if contact.keeps_forces:
            pairs.setdefault(contact.pair, []).append(contact)
    return {
        name: halves
        for name, halves in pairs.items()
        if any(half.gap.norm() > 0 for half in halves)
    }


def _relative_stiffness(halves: Sequence[Contact]) -> list[Floats]:
    """p^ of each half at all points (1/m^2): p over the P of both; even where p is infinite."""
    weights = [half.interface.points.weight for half in halves]
    stiffness = [half.half.stiffness for half in halves]
    if any(np.isinf(p).any() for p in stiffness):
        return [np.full(len(w), 1 / (len(halves) * w.sum())) for w in weights]
    P = sum(half.P for half in halves)
    return [p / P for p in stiffness]


def few_forces(halves: Sequence[Contact], carried: Sequence[csr_array]) -> tuple[csr_array, ...]:
    """J, and Q^T sqrt(W p^) of further rows at the points, the rows that this rank is left with.

    Parameters
    ----------
    halves
        The half passes of a contact.
    carried
        Further rows at the points of this rank of each.
    """
    gaps, others, places = [], [], []
    for half, share, rows in zip(halves, _relative_stiffness(halves), carried, strict=True):
        weight = half.weight(share)
        closed = np.flatnonzero(weight.array_r)  # points that have lifted off bear no force
        root = diags_array(np.sqrt(weight.array_r[closed]))
        destroy(weight)
        gaps.append(csr_array(root @ local_part(half.gap)[closed]))
        others.append(csr_array(root @ rows[closed]))
        places.append(half.interface.local_points.x[closed])
    gap, other = (csr_array(vstack(parts)) for parts in (gaps, others))
    return compressed(gap, other, np.concatenate(places), halves[0].interface.comm)


def _projected(halves: Sequence[Contact]) -> ContactForces:
    """Multipliers of mortar and bonded contact."""
    shares = _relative_stiffness(halves)
    parts = [half.compliance(share) for half, share in zip(halves, shares, strict=True)]
    closure = one_below_the_other([half.gap for half in halves])
    slip = None
    if any(half.slip is not None for half in halves):
        rows = [_slip(half) for half in halves]
        slip = one_below_the_other(rows)
        destroy(*(row for row, half in zip(rows, halves, strict=True) if row is not half.slip))
    compliance = block_diagonal(parts).convert("aij")
    destroy(*parts)
    return ContactForces(closure, slip, compliance)


def _slip(half: Contact) -> Any:
    """Its slip operator; without friction one of zeros."""
    if half.slip is not None:
        return half.slip
    zero = half.gap.duplicate()
    zero.assemble()
    return zero


def _at_points(halves: Sequence[Contact]) -> ContactForces:
    """Forces at points, as few as there are independent gaps."""
    template = halves[0].gap
    slips = [
        local_part(half.slip) if half.slip is not None else csr_array(local_part(half.gap).shape)
        for half in halves
    ]
    closure, reaction = few_forces(halves, slips)
    columns = template.getSizes()[1]
    frictional = any(half.slip is not None for half in halves)
    return ContactForces(
        distributed(closure, columns, template.comm),
        distributed(reaction, columns, template.comm) if frictional else None,
        identity(closure.shape[0], template.comm),
    )
