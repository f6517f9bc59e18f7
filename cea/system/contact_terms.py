"""Pieces of the pencil and parameters that contacts bring, both halves of a full pass together."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from cea.contact.operators import Contact
from cea.contact.saddle import contact_forces
from cea.eigen.multipliers import ForcesOfContact
from cea.eigen.parameters import NOTHING, Coefficient, Parameter
from cea.eigen.pencil import Term


@dataclass(frozen=True)
class ContactPairs:
    """Contacts of a system by the name of the pair they belong to.

    Parameters
    ----------
    contacts
        Contact matrices of all half passes.
    """

    contacts: tuple[Contact, ...]

    def terms(self, keeping: Sequence[Contact]) -> Iterator[Term]:
        """K_n and K_f of each half pass that keeps no forces."""
        total, references = self.stiffnesses(), self.references()
        names = {contact.name for contact in keeping}
        for contact in self.contacts:
            if contact.name in names:
                continue
            P = {}
            if contact.half.law.linear:
                P = {f"contacts.{contact.pair}.P": (total[contact.pair], 1.0)}
            yield Term("stiffness", contact.stiffness, Coefficient.of(P), contact=True)
            if contact.friction is not None and self.rubs(contact):
                mu = {f"contacts.{contact.pair}.mu": (references[contact.pair], 1.0)}
                coefficient = Coefficient.of(P | mu, factor=-1.0)
                rubbing = contact.friction
                yield Term("stiffness", rubbing, coefficient, symmetric=False, contact=True)

    def forces(
        self, keeping: Sequence[Contact], stiffness_diagonal: Any
    ) -> Iterator[ForcesOfContact]:
        """Forces of each contact that keeps them."""
        references, laws = self.references(), self._with_laws()
        rubbing = [c if self.rubs(c) else replace(c, slip=None) for c in keeping]
        for name, forces in contact_forces(rubbing).items():
            P, mu = f"contacts.{name}.P", f"contacts.{name}.mu"
            slips = Coefficient.of({mu: (references[name], 1.0)}) if forces.slip else NOTHING
            compliance = Coefficient.of({P: (1.0, -1.0)})
            if name in laws:
                compliance = Coefficient.of({}, factor=1 / self.stiffnesses()[name])
            yield ForcesOfContact(
                forces.closure,
                forces.slip,
                forces.compliance,
                inverse_stiffness=compliance,
                friction=slips,
                body_stiffness=forces.body_stiffness(stiffness_diagonal),
            )

    def parameters(self) -> Iterator[Parameter]:
        """P and mu of each contact, where they are parameters."""
        saddle = {c.pair for c in self.contacts if c.half.form == "saddle"}
        laws = self._with_laws()
        for name, P in self.stiffnesses().items():
            if name in laws:
                continue
            finite = name not in saddle
            yield Parameter(f"contacts.{name}.P", P, "N/m", positive=True, finite=finite)
        for name, reference in self.references().items():
            acts = any(_acts(c) for c in self.halves(name))
            yield Parameter(f"contacts.{name}.mu", reference if acts else 0.0)

    def stiffnesses(self) -> dict[str, float]:
        """P of each contact, both halves of a full pass together."""
        total: dict[str, float] = {}
        for contact in self.contacts:
            total[contact.pair] = total.get(contact.pair, 0.0) + contact.P
        return total

    def references(self) -> dict[str, float]:
        """What mu of each contact is relative to; 1 where its halves do not have the same."""
        found: dict[str, set[float]] = {}
        for contact in self.contacts:
            if any(c.slip is not None for c in self.halves(contact.pair)):
                own = contact.mu if self.rubs(contact) else 0.0
                found.setdefault(contact.pair, set()).add(own)
        return {name: each.pop() if len(each) == 1 else 1.0 for name, each in found.items()}

    def halves(self, name: str) -> list[Contact]:
        """The half passes of one contact."""
        return [c for c in self.contacts if c.pair == name]

    def rubs(self, contact: Contact) -> bool:
        """Whether a half has friction where its contact has any: on one side mu may vanish."""
        return _acts(contact) or not any(_acts(c) for c in self.halves(contact.pair))

    def _with_laws(self) -> set[str]:
        """Contacts whose stiffness is that of a law in the state that is linearised about."""
        return {contact.pair for contact in self.contacts if not contact.half.law.linear}


def _acts(contact: Contact) -> bool:
    return contact.half.friction is not None and contact.half.friction.acts
