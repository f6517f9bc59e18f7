"""What contacts bring to a pencil: the form each takes, pieces and parameters, halves together.

K_n added to K costs the digits by which it is larger: rounding of the sum, eps times the larger,
stands beside the smaller. In the saddle form, and where gaps are projected, nothing is added.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from cea.contact.contact import Contact
from cea.contact.formulations import Form
from cea.eigen.parameters import Coefficient, Parameter
from cea.eigen.pencil import Term
from cea.errors import ResultWarning
from cea.matrices import destroy, squared

MOST_DIGITS = 6.0
"""Digits that the penalty form may cost."""


def by_pair(contacts: Sequence[Contact]) -> dict[str, list[Contact]]:
    """Half passes by the name of the contact they belong to."""
    pairs: dict[str, list[Contact]] = {}
    for contact in contacts:
        pairs.setdefault(contact.pair, []).append(contact)
    return pairs


def stiffnesses(contacts: Sequence[Contact]) -> dict[str, float]:
    """P of each contact, both halves of a full pass together."""
    return {name: sum(half.P for half in halves) for name, halves in by_pair(contacts).items()}


def with_own_friction(contacts: Sequence[Contact]) -> list[Contact]:
    """Those half passes whose friction counts: where the other half has some, zero is none."""
    pairs = by_pair(contacts)
    return [
        contact
        for contact in contacts
        if contact.has_friction or not any(half.has_friction for half in pairs[contact.pair])
    ]


def friction_references(contacts: Sequence[Contact]) -> dict[str, float]:
    """What mu of each contact is relative to; 1 where its halves do not have the same."""
    counted, references = with_own_friction(contacts), {}
    for name, halves in by_pair(contacts).items():
        if any(half.slip is not None for half in halves):
            values = {half.mu if half in counted else 0.0 for half in halves}
            references[name] = values.pop() if len(values) == 1 else 1.0
    return references


def contact_terms(
    contacts: Sequence[Contact], among: Sequence[Contact], friction: dict[str, float]
) -> Iterator[Term]:
    """K_n and K_f of some of the half passes, whose forces are eliminated."""
    total, counted = stiffnesses(contacts), with_own_friction(contacts)
    for contact in among:
        path = f"contacts.{contact.pair}"
        P = {f"{path}.P": (total[contact.pair], 1.0)} if contact.law.linear else {}
        yield Term("stiffness", contact.K_n, Coefficient.of(P), contact=True)
        if contact.K_f is not None and contact in counted:
            mu = {f"{path}.mu": (friction[contact.pair], 1.0)}
            coefficient = Coefficient.of(P | mu, factor=-1.0)
            yield Term("stiffness", contact.K_f, coefficient, symmetric=False, contact=True)


def contact_parameters(
    contacts: Sequence[Contact], friction: dict[str, float]
) -> Iterator[Parameter]:
    """P and mu of each contact, where they are parameters."""
    pairs = by_pair(contacts)
    for name, P in stiffnesses(contacts).items():
        if all(half.law.linear for half in pairs[name]):
            finite = all(half.form != "saddle" for half in pairs[name])
            yield Parameter(f"contacts.{name}.P", P, "N/m", positive=True, finite=finite)
    for name, reference in friction.items():
        acts = any(half.has_friction for half in pairs[name])
        yield Parameter(f"contacts.{name}.mu", reference if acts else 0.0)


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
