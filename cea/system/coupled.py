"""Coupled matrices of bodies in frictional contact, kept apart until a solver sums them.

    (lambda^2 M + K + K_n - K_f) x = 0

On every rank the unknowns are the free dofs of the first body, then those of the second, and so on.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cea.body import Body, Floats
from cea.contact.interface import Interface
from cea.contact.operators import Contact, ContactLaw, assemble_contact
from cea.contact.saddle import Multipliers, multipliers_of
from cea.matrices import block_diagonal, destroy, gather, total
from cea.petsc import PETSc


@dataclass(frozen=True)
class HalfPass:
    """One side's points against the other: what :func:`couple` makes a :class:`Contact` of.

    Parameters
    ----------
    a, b
        Names of the bodies on its two sides.
    interface
        Its points, which lie on a.
    law
        Its stiffness and friction.
    pair
        Name of the contact it belongs to, where that is not its own: a full pass has two halves.
    """

    a: str
    b: str
    interface: Interface
    law: ContactLaw
    pair: str | None = None


@dataclass(frozen=True)
class CoupledSystem:
    """Matrices of all bodies and contacts.

    Parameters
    ----------
    bodies
        Bodies by name, in the order of the unknowns.
    stiffness
        K of all bodies, PETSc AIJ (N/m).
    mass
        M of all bodies, PETSc AIJ (kg), None in static scenes.
    load
        Forces (N), PETSc vector, None where no body has any.
    contacts
        Contact matrices.
    index_sets
        Unknowns of each body, PETSc index sets by name.
    """

    bodies: Mapping[str, Body]
    stiffness: Any
    mass: Any | None
    load: Any | None
    contacts: tuple[Contact, ...]
    index_sets: Mapping[str, Any]

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.stiffness.getSize()[0])

    def symmetric_stiffness(self) -> Any:
        """K + K_n, a new PETSc AIJ matrix; contacts in the saddle form have no K_n."""
        normal = [c.stiffness for c in self.contacts if c.stiffness is not None]
        return total([self.stiffness, *normal])

    def friction(self) -> Any | None:
        """K_f of all contacts, None without friction; those in the saddle form have none."""
        parts = [c.friction for c in self.contacts if c.friction is not None]
        return total(parts) if parts else None

    def multipliers(self) -> Multipliers | None:
        """Contact forces that are unknowns of their own; None where no contact has the form."""
        return multipliers_of(self.contacts)

    def displacement(self, x: Any, body: str, *, everywhere: bool = True) -> Floats:
        """Full displacement (m) of one body, shape (dim * num_scalar_dofs,).

        Parameters
        ----------
        x
            Unknowns, PETSc vector.
        body
            Name of the body.
        everywhere
            Whether every rank gets it; otherwise rank 0 does, and others get an empty array.
        """
        part = x.getSubVector(self.index_sets[body])
        full = self.bodies[body].expansion.createVecLeft()
        self.bodies[body].expansion.mult(part, full)
        x.restoreSubVector(self.index_sets[body], part)
        displacement = gather(full, everywhere=everywhere)
        destroy(full)
        return displacement


def couple(
    bodies: Mapping[str, Body],
    contacts: Mapping[str, HalfPass],
    *,
    with_mass: bool = True,
    with_load: bool = False,
    leave_out: bool = True,
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
    """
    PETSc.garbage_cleanup()  # on several ranks what earlier systems left waits for this call
    nest = block_diagonal([body.stiffness() for body in bodies.values()])
    index_sets = dict(zip(bodies, nest.getNestISs()[0], strict=True))
    stiffness = nest.convert("aij")
    mass = block_diagonal([b.mass() for b in bodies.values()]).convert("aij") if with_mass else None
    load = None
    if with_load:
        load = stiffness.createVecRight()
        for name, body in bodies.items():
            part = load.getSubVector(index_sets[name])
            body.load().copy(part)
            load.restoreSubVector(index_sets[name], part)
    return CoupledSystem(
        bodies=bodies,
        stiffness=stiffness,
        mass=mass,
        load=load,
        contacts=tuple(
            assemble_contact(
                bodies,
                name,
                half.pair or name,
                (half.a, half.b),
                half.interface,
                half.law,
                leave_out=leave_out,
            )
            for name, half in contacts.items()
        ),
        index_sets=index_sets,
    )
