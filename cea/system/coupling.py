"""Coupled matrices of bodies in frictional contact, from bodies and half passes."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from cea.body import Body
from cea.contact.assembly import assemble_contact
from cea.contact.forms import penalty_digits, with_forms
from cea.contact.half_pass import HalfPass
from cea.contact.operators import Contact
from cea.contact.sliding import Sliding
from cea.errors import InputError
from cea.matrices import block_diagonal, destroy
from cea.petsc import PETSc
from cea.system.body_pieces import BodyPieces
from cea.system.body_terms import Motion
from cea.system.coupled import CoupledSystem


def couple(
    bodies: Mapping[str, Body],
    contacts: Mapping[str, HalfPass],
    *,
    with_mass: bool = True,
    with_load: bool = False,
    leave_out: bool = True,
    motions: Mapping[str, Motion] | None = None,
    sliding: Mapping[str, Sliding] | None = None,
) -> CoupledSystem:
    """Assemble the coupled matrices.

    Parameters
    ----------
    bodies
        Bodies by name.
    contacts
        Half passes by name.
    with_mass
        Whether the mass is needed.
    with_load
        Whether the loads are needed.
    leave_out
        Whether slip operators and K_f are left out where mu = 0.
    motions
        Damping and rotation of bodies that have any, by name. Without mass they act on
        displacements at rest in space alone.
    sliding
        How half passes slide, by name, where that damps; it needs the mass.
    """
    PETSc.garbage_cleanup()  # on several ranks what earlier systems left waits for this call
    nest = block_diagonal([body.stiffness() for body in bodies.values()])
    index_sets = dict(zip(bodies, nest.getNestISs()[0], strict=True))
    template = nest.createVecRight()
    destroy(nest)
    made = [
        assemble_contact(bodies, name, half, leave_out=leave_out) for name, half in contacts.items()
    ]
    load = _load(bodies, made, template, index_sets) if with_load else None
    diagonal = _stiffness_diagonal(bodies, template)
    digits = penalty_digits(made, diagonal)
    return CoupledSystem(
        bodies=bodies,
        contacts=with_forms(made, digits),
        template=template,
        index_sets=index_sets,
        load=load,
        stiffness_diagonal=diagonal,
        penalty_digits=digits,
        pieces=BodyPieces(bodies, motions or {}, with_mass, template.comm),
        sliding=sliding or {} if with_mass else {},
    )


def _stiffness_diagonal(bodies: Mapping[str, Body], template: Any) -> Any:
    """Diagonal of K of all bodies (N/m), PETSc vector of the layout of the unknowns."""
    parts = [body.stiffness().getDiagonal() for body in bodies.values()]
    whole = template.duplicate()
    whole.array[:] = np.concatenate([part.array_r for part in parts])
    destroy(*parts)
    return whole


def _load(
    bodies: Mapping[str, Body], contacts: Iterable[Contact], template: Any, index_sets: Any
) -> Any:
    """Forces (N) of loads and of displacements that supports prescribe, PETSc vector."""
    load = template.duplicate()
    for name, body in bodies.items():
        part = load.getSubVector(index_sets[name])
        body.load().copy(part)
        load.restoreSubVector(index_sets[name], part)
    for contact in contacts:
        if contact.prescribed is not None and contact.half.law.linear:
            force = _force_of_prescribed(contact)
            load.axpy(-1.0, force)
            destroy(force)
    return load


def _force_of_prescribed(contact: Contact) -> Any:
    """Forces (N) of a closure that is prescribed, PETSc vector (free), against the motion.

    The closure is G x + e with e prescribed; contact forces that stay unknowns are then those of
    G x alone, of the same stiffness.

    Raises
    ------
    InputError
        When the contact is projected, lumped or tied, whose forces are not those at its points.
    """
    half = contact.half
    if half.coupling != "pointwise" or not contact.has_pressure:
        allowed = (
            "pointwise and of finite stiffness where a support that prescribes a displacement "
            "meets a side; or c_n, a law of the gap"
        )
        raise InputError(f"contacts.{contact.pair}.formulation", half.coupling, allowed)
    assert contact.prescribed is not None
    rubs = half.friction is not None and half.friction.acts
    return contact.reactions.forces(half.stiffness * contact.prescribed, friction=rubs)
