"""Contact with forces as Lagrange multipliers: the saddle form, and all mortar contact.

    [ K   L^T  ] [x]   [r]
    [ J   -C/P ] [f] = [0],     L = J - R,

Eliminating f gives the penalty form: P L^T C^-1 J = K_n - K_f. The saddle form loses no digits as
P grows, and P = infinity ties the sides along the normal but keeps friction. With
p = P p^,

    points:   sqrt(W p^) G = Q J,     R = Q^T sqrt(W p^) diag(mu) T,     C = 1
    mortar:   J = B,                  R = B_k,                           C_ij = int psi_i psi_j / p^

all of them sparse. A rule has more points than there are independent gaps: the factorisation drops
dependent rows (:mod:`cea.contact.compression`).
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack

from cea.arrays import Floats
from cea.contact.compression import compressed
from cea.contact.contact import Contact, by_pair, powers_of
from cea.eigen.coefficients import NOTHING, Coefficient
from cea.eigen.multipliers import ForcesOfContact
from cea.matrices import (
    applied,
    block_diagonal,
    destroy,
    diagonal_of,
    distributed,
    identity,
    local_part,
    of_entries,
    one_below_the_other,
)
from cea.petsc import MPI

_UNFELT = 1e-24
"""Relative stiffness of a force, compared with the largest of a contact, treated as zero."""


def forces_of_contacts(contacts: Sequence[Contact], stiffness: Floats) -> Iterator[ForcesOfContact]:
    """Yield the multipliers of each contact that has any; collective.

    ``stiffness`` is the diagonal of K of the bodies (N/m), the rows of this rank.
    """
    for name, halves in with_multipliers(contacts).items():
        made = (_at_points if halves[0].traces is None else _projected)(halves)
        closure, slip, compliance = made
        inverse = Coefficient({f"contacts.{name}.P": (1.0, -1.0)})
        if not halves[0].law.linear:
            inverse = Coefficient({}, factor=1 / sum(half.P for half in halves))
        mu = NOTHING if slip is None else Coefficient(powers_of(halves)[1])
        soft = _body_stiffness(closure, compliance, stiffness)
        yield ForcesOfContact(closure, slip, compliance, inverse, mu, soft)


def with_multipliers(contacts: Sequence[Contact]) -> dict[str, list[Contact]]:
    """Return half passes with multipliers by contact, except between sides without free dofs.

    The halves of a full pass share one P.
    """
    return {
        name: halves
        for name, halves in by_pair([each for each in contacts if each.has_multipliers]).items()
        if any(half.gap.norm() > 0 for half in halves)
    }


def few_forces(halves: Sequence[Contact], carried: Sequence[csr_array]) -> tuple[csr_array, ...]:
    """Return J, and Q^T sqrt(W p^) times other rows at the points; the rows of this rank."""
    gaps, others, places = [], [], []
    for half, share, rows in zip(halves, _relative_stiffness(halves), carried, strict=True):
        weight = half.weight(share)
        closed = np.flatnonzero(weight)  # open points have no force
        root = diags_array(np.sqrt(weight[closed]))
        gaps.append(csr_array(root @ local_part(half.gap)[closed]))
        others.append(csr_array(root @ rows[closed]))
        places.append(half.interface.local_points.x[closed])
    gap, other = (csr_array(vstack(parts)) for parts in (gaps, others))
    return compressed(gap, other, np.concatenate(places), halves[0].interface.comm)


def _relative_stiffness(halves: Sequence[Contact]) -> list[Floats]:
    """Return p^ = p / P of each half at all points (1/m^2), P of both halves; uniform if tied."""
    if any(half.tied for half in halves):
        weights = [half.interface.points.weight for half in halves]
        return [np.full(len(w), 1 / (len(halves) * w.sum())) for w in weights]
    P = sum(half.P for half in halves)
    return [half.slope / P for half in halves]


def _projected(halves: Sequence[Contact]) -> tuple[Any, Any | None, Any]:
    """Return J, R and C of mortar and bonded contact."""
    shares = _relative_stiffness(halves)
    parts = [half.compliance(share) for half, share in zip(halves, shares, strict=True)]
    closure, slip = one_below_the_other([half.gap for half in halves]), None
    if halves[0].slip is not None:
        slip = one_below_the_other([half.slip for half in halves])
    compliance = block_diagonal(parts).convert("aij")
    destroy(*parts)
    return closure, slip, compliance


def _at_points(halves: Sequence[Contact]) -> tuple[Any, Any | None, Any]:
    """Return J, R and C of pointwise contact, compressed to the independent gaps."""
    gap, frictional = halves[0].gap, halves[0].slip is not None
    slips = [
        local_part(half.slip) if frictional else csr_array(local_part(half.gap).shape)
        for half in halves
    ]
    closure, reaction = few_forces(halves, slips)
    columns, comm = gap.getSizes()[1], gap.comm
    slip = distributed(reaction, columns, comm) if frictional else None
    return distributed(closure, columns, comm), slip, identity(closure.shape[0], comm)


def _body_stiffness(closure: Any, compliance: Any, stiffness: Floats) -> tuple[float, float]:
    """Return P (N/m) at which the stiffest and the softest force match the body stiffness."""
    squares, comm = of_entries(np.square, closure), closure.comm.tompi4py()
    relative = applied(squares, 1 / stiffness) / diagonal_of(compliance)
    destroy(squares)
    stiffest = comm.allreduce(relative.max(initial=0.0), MPI.MAX)
    felt = relative[relative > _UNFELT * stiffest]
    softest = comm.allreduce(felt.min(initial=stiffest), MPI.MIN)
    return 1 / stiffest, 1 / softest
