"""Pieces of the pencil and parameters that contacts bring, both halves of a full pass together."""

from collections.abc import Iterator, Sequence

from cea.contact.contact import Contact
from cea.eigen.parameters import Coefficient, Parameter
from cea.eigen.pencil import Term


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
