"""Coupled matrices of bodies in frictional contact, as separate terms of a pencil.

    (lambda^2 M + lambda (C + Y) + K + K_n - K_f) x = 0

On every rank the unknowns are the free dofs of the first body, then those of the second, and so on.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact, assembled, by_pair
from cea.contact.saddle import forces_of_contacts
from cea.eigen.pencil import Matrices, Pencil, Term
from cea.errors import InputError
from cea.matrices import applied
from cea.motion import Motion
from cea.petsc import PETSc
from cea.system.body_terms import BodyTerms
from cea.system.contact_terms import (
    contact_parameters,
    contact_terms,
    form_for,
    penalty_digits,
    stiffness_diagonal,
    with_forms,
)

if TYPE_CHECKING:
    from cea.system.steady_state import SteadySliding


_LARGE = 50_000
"""Unknowns from which on a bound by what lies near contacts is cheaper."""


@dataclass(frozen=True)
class CoupledSystem:
    """Matrices of all bodies and contacts."""

    bodies: Mapping[str, Body]  # bodies by name, in the order of the unknowns
    # contacts with their operators, the half passes one after another
    contacts: tuple[Contact, ...]
    template: Any  # PETSc vector of the layout of the unknowns
    load: Any | None  # forces (N), PETSc vector, or None if not requested
    # terms of the pencil from each body, with its damping and rotation
    pieces: Mapping[str, BodyTerms]
    with_mass: bool  # whether the pencil has mass and damping
    # steady sliding state of the linearisation, or None
    steady: "SteadySliding | None" = None
    # geometric stiffness of the stresses of that state by body, PETSc AIJ (N/m); empty if not
    # requested
    prestress: Mapping[str, Any] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.template.getSize())

    @property
    def softens(self) -> bool:
        """Whether any body has convective stiffness, which reduces its stiffness."""
        rotations = (each.motion.rotation for each in self.pieces.values())
        return any(each is not None and each.convective_stiffness for each in rotations)

    def keeps_form(self, contact: str, values: Mapping[str, float]) -> bool:
        """Return whether a contact would have the same form for other parameter values."""
        halves = by_pair(self.contacts)[contact]
        form = form_for(penalty_digits(self.bodies, halves, values)[contact])
        return all(half.lumped is not None or half.form == form for half in halves)

    def vector(self) -> Any:
        """Return a new zero PETSc vector of unknowns."""
        vector = self.template.duplicate()
        vector.set(0.0)
        return vector

    def pencil(self, *, eliminate: bool = False) -> Pencil:
        """Return the parametric pencil of the system.

        Its parameters are ``bodies.<name>.material.E`` and ``.rho``, and for each contact
        ``contacts.<name>.P``, the integral of p (N/m), and ``contacts.<name>.mu``, a factor if mu
        varies. There is no mu if friction was left out, and no P if p is the slope of a law in a
        steady sliding state, which stays fixed. Damping, rotation and sliding add further
        parameters.

        Parameters
        ----------
        eliminate
            Whether to eliminate all contact forces; requires that no contact is tied.
        """
        pieces = [piece for each in self.pieces.values() for piece in each.pieces]
        terms = [piece for piece in pieces if isinstance(piece, Term)]
        for name, matrix in self.prestress.items():
            terms.append(Term("stiffness", self.pieces[name].placed(matrix)))
        terms += contact_terms(
            self.bodies, self.contacts, eliminate=eliminate, with_mass=self.with_mass
        )
        parameters = [one for each in self.pieces.values() for one in each.parameters()]
        parameters += contact_parameters(self.contacts, with_mass=self.with_mass)
        stiffness = stiffness_diagonal(self.bodies, {})
        return Pencil(
            terms,
            parameters,
            list(forces_of_contacts(() if eliminate else self.contacts, stiffness)),
            [term for each in self.pieces.values() for term in each.modal],
            [piece for piece in pieces if not isinstance(piece, Term)],
            None if self.size < _LARGE or self.prestress or self.softens else self._near_contacts,
        )

    def _near_contacts(self, values: Mapping[str, float], whole: Matrices) -> Matrices | None:
        from cea.system.near_contacts import near_contacts  # imported only for large systems

        return near_contacts(self.pieces, self.contacts, values, whole)

    def linearised(
        self, steady: "SteadySliding", *, geometric_stiffness: bool = False
    ) -> "CoupledSystem":
        """Return the system of small motions about a steady sliding state."""
        contacts = []
        for contact in self.contacts:
            state = steady.contacts.get(contact.name)
            contacts.append(contact if state is None else replace(contact, closure=state.closure))
        prestress = {
            name: body.geometric_stiffness(self.displacement(steady.displacement, name))
            for name, body in self.bodies.items()
            if geometric_stiffness
        }
        formed = with_forms(self.bodies, contacts)
        return replace(self, contacts=formed, steady=steady, prestress=prestress)

    def displacement(self, x: Any, body: str) -> Floats:
        """Return the full displacement (m) of a body, prescribed parts included, (dim * dofs,)."""
        own = self.bodies[body]
        full = applied(own.expansion, x.array_r[self.pieces[body].rows])
        if own.prescribed is not None:
            full += own.prescribed
        return np.concatenate(own.comm.allgather(full))


def couple(
    bodies: Mapping[str, Body],
    contacts: Sequence[Contact],
    *,
    with_mass: bool = True,
    with_load: bool = False,
    leave_out: bool = True,
    motions: Mapping[str, Motion] | None = None,
) -> CoupledSystem:
    """Assemble the coupled matrices of bodies and contacts, given as half passes.

    ``leave_out`` omits slip operators and K_f where mu = 0. ``motions`` are damping and rotation by
    body; without mass only their terms for displacements at rest in space remain.
    """
    PETSc.garbage_cleanup()  # frees objects of earlier systems, which is collective
    sizes = tuple(body.expansion.getSizes()[1] for body in bodies.values())
    template = PETSc.Vec().create(next(iter(bodies.values())).expansion.comm)
    template.setSizes((sum(local for local, _ in sizes), PETSc.DETERMINE))
    template.setUp()
    frictional = {contact.pair for contact in contacts if contact.has_friction}
    made = [
        assembled(bodies, contact, frictional=contact.pair in frictional, leave_out=leave_out)
        for contact in contacts
    ]
    pieces = {}
    for number, (name, body) in enumerate(bodies.items()):
        motion = (motions or {}).get(name, Motion())
        pieces[name] = BodyTerms(name, body, motion, with_mass, sizes, number)
    return CoupledSystem(
        bodies=bodies,
        contacts=with_forms(bodies, made),
        template=template,
        load=_load(bodies, made, template) if with_load else None,
        pieces=pieces,
        with_mass=with_mass,
    )


def _load(bodies: Mapping[str, Body], contacts: Iterable[Contact], template: Any) -> Any:
    """Return the forces (N) of loads and prescribed displacements, PETSc vector."""
    load = template.duplicate()
    load.array[:] = np.concatenate([body.load().array_r for body in bodies.values()])
    for contact in contacts:
        if contact.prescribed is None or not contact.law.linear:
            continue
        if contact.coupling != "pointwise" or not contact.has_pressure:
            allowed = (
                "pointwise and of finite stiffness if a support prescribes a displacement of a "
                "side; or a law with c_n"
            )
            raise InputError(f"contacts.{contact.pair}.formulation", contact.coupling, allowed)
        load.array[:] -= contact.force(contact.slope * contact.prescribed)
    return load
