"""Contacts of given stiffness that displacements which supports prescribe close in part."""

from typing import Any

from cea.contact.operators import Contact
from cea.errors import InputError


def force_of_prescribed(contact: Contact) -> Any:
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
