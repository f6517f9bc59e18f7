"""Penalty or saddle form: which of them a contact takes where that is left open.

K_n added to K costs the digits by which it is larger: rounding of the sum, eps times the larger,
stands beside the smaller. In the saddle form, and where gaps are projected, nothing is added.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from cea.contact.contact import Contact
from cea.contact.formulations import Form
from cea.errors import ResultWarning
from cea.matrices import destroy, distributed, local_part

MOST_DIGITS = 6.0
"""Digits that the penalty form may cost."""


def penalty_digits(contacts: Sequence[Contact], stiffness: Any) -> dict[str, float]:
    """Digits that the penalty form costs, by contact; none where gaps are projected.

    log10 of the largest diagonal entry of K_n relative to that of K; infinite where sides are tied.
    """
    digits: dict[str, float] = {}
    for contact in contacts:
        if contact.tied:
            lost = inf
        elif contact.awaits_state or (contact.is_projected and contact.law.linear):
            lost = 0.0
        else:
            lost = _lost(contact, stiffness)
        digits[contact.pair] = max(lost, digits.get(contact.pair, 0.0))
    return digits


def _lost(contact: Contact, stiffness: Any) -> float:
    if contact.penalty_only:
        own = contact.K_n.getDiagonal()
    else:
        weight, own = contact.weight(contact.slope), stiffness.duplicate()
        squares = squared(contact.gap)
        squares.multTranspose(weight, own)
        destroy(weight, squares)
    own.pointwiseDivide(own, stiffness)
    ratio = own.max()[1]
    destroy(own)
    return float(np.log10(max(ratio, np.finfo(float).tiny)))


def squared(matrix: Any) -> Any:
    """Squares of the entries, PETSc AIJ."""
    part = local_part(matrix)
    part.data = part.data**2
    return distributed(part, matrix.getSizes()[1], matrix.comm)


def form_for(digits: float) -> Form:
    """The form that a contact takes where it is left open, by the digits a penalty would cost."""
    return "saddle" if digits > MOST_DIGITS else "penalty"


def with_forms(contacts: Sequence[Contact], digits: Mapping[str, float]) -> tuple[Contact, ...]:
    """Contacts whose forms are all chosen; lumped ones have no other than the penalty.

    Where the stiffness is not known before a state of steady sliding is, the form stays open.
    """

    def chosen(contact: Contact) -> Contact:
        if contact.form is not None or contact.awaits_state:
            return contact
        form = "penalty" if contact.penalty_only else form_for(digits[contact.pair])
        return replace(contact, form=form)

    return tuple(chosen(contact) for contact in contacts)


def penalty_warnings(
    contacts: Sequence[Contact], digits: Mapping[str, float]
) -> tuple[ResultWarning, ...]:
    """Where the penalty form costs too much, a warning for each contact."""
    costly = {c.pair: digits[c.pair] for c in contacts if not c.has_multipliers}
    return tuple(
        ResultWarning(
            "penalty-rounding",
            f"contact {name} is {10**lost:.1g} times as stiff as its bodies: the penalty form "
            f"loses {lost:.1f} digits to rounding",
            {"contact": name, "digits": lost},
        )
        for name, lost in costly.items()
        if lost > MOST_DIGITS
    )
