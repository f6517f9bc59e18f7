"""Penalty or saddle form: which of them a contact takes where that is left open.

K_n added to K costs the digits by which it is larger: rounding of the sum, eps times the larger,
stands beside the smaller. In the saddle form, and where gaps are projected, nothing is added.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from cea.contact.operators import Contact
from cea.matrices import destroy, distributed, local_part
from cea.warned import ResultWarning

_MOST_DIGITS = 6.0
"""Digits that the penalty form may cost."""


def with_forms(contacts: Iterable[Contact], stiffness: Any) -> tuple[Contact, ...]:
    """Contacts whose forms are all chosen: saddle where the penalty would cost too many digits.

    The halves of a full pass take the same form; projected contact, which loses none in either,
    the penalty form where it can.

    Parameters
    ----------
    contacts
        All contacts.
    stiffness
        Diagonal of K of all bodies (N/m), PETSc vector.
    """
    contacts = tuple(contacts)
    stiff = {
        contact.pair
        for contact in contacts
        if contact.half.coupling != "lumped" and _costs_too_much(contact, stiffness)
    }
    return tuple(
        contact
        if contact.half.form is not None
        else replace(
            contact,
            half=replace(contact.half, form="saddle" if contact.pair in stiff else "penalty"),
        )
        for contact in contacts
    )


def penalty_warnings(
    contacts: Iterable[Contact], stiffness: Any
) -> tuple[ResultWarning, ...]:
    """What the penalty form costs where it costs too much, a warning for each contact.

    Parameters
    ----------
    contacts
        All contacts, their forms chosen.
    stiffness
        Diagonal of K of all bodies (N/m), PETSc vector.
    """
    lost: dict[str, float] = {}
    for contact in contacts:
        if not contact.keeps_forces:
            digits = lost_digits(contact, stiffness)
            lost[contact.pair] = max(digits, lost.get(contact.pair, 0.0))
    return tuple(
        ResultWarning(
            "penalty-rounding",
            f"contact {name} is {10**digits:.1g} times as stiff as the bodies: its penalty form "
            f"loses {digits:.1f} digits to rounding",
            {"contact": name, "digits": digits},
        )
        for name, digits in lost.items()
        if digits > _MOST_DIGITS
    )


def lost_digits(contact: Contact, stiffness: Any) -> float:
    """Digits that adding K_n to K costs: log10 of its largest diagonal entry relative to that of K.

    Parameters
    ----------
    contact
        A contact whose gaps are not projected.
    stiffness
        Diagonal of K of all bodies (N/m), PETSc vector.
    """
    if np.isinf(contact.half.stiffness).any():
        return inf
    weight, own = contact.weight(contact.half.stiffness), stiffness.duplicate()
    squares = squared(contact.gap)
    squares.multTranspose(weight, own)
    own.pointwiseDivide(own, stiffness)
    ratio = own.max()[1]
    destroy(weight, own, squares)
    return float(np.log10(max(ratio, 1.0)))


def squared(matrix: Any) -> Any:
    """Squares of the entries, PETSc AIJ."""
    part = local_part(matrix)
    part.data = part.data**2
    return distributed(part, matrix.getSizes()[1], matrix.comm)


def _costs_too_much(contact: Contact, stiffness: Any) -> bool:
    if contact.projection is not None:
        return bool(np.isinf(contact.half.stiffness).any())
    return lost_digits(contact, stiffness) > _MOST_DIGITS
