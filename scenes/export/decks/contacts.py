"""Contacts of a deck, and the rigid motions of the sliding bodies.

In a scene the contacts are closed by assumption. A deck has to close them: the sides overlap by a
closure that is so small that nothing deforms; all pressures are the contact stiffness times it.

Friction on side a acts against the velocity of a relative to b: if side a is at rest, side b moves
in the direction of friction on a.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from cea.contact.friction import AlongVector, Circumferential
from cea.errors import InputError
from cea.surface import Surface
from scenes.export.decks.bodies import DeckBody, set_name
from scenes.export.decks.model import keyword, numbers
from scenes.spec.contact import ContactSpec

CLOSURE = 1e-12
"""Closure, relative to the size of the bodies: slip is then small and rounding of coordinates is
smaller."""
STICK = 1e-5
"""Stick stiffness, relative to the contact stiffness."""
MORE_FRICTION = 2.0
"""Friction coefficient of the static step, relative to that of the scene."""
_TANGENT = 1e-6
"""Relative normal component of a velocity below which it is treated as tangential."""


@dataclass(frozen=True)
class DeckContact:
    """A contact pair of a deck."""

    interaction: str  # name of its surface interaction
    slave: str  # surface of side a, which has the integration points
    master: str
    stiffness: float  # p (N/m^3), uniform
    mu: float


def deck_contacts(
    contacts: Mapping[str, ContactSpec], surfaces: Mapping[str, Surface]
) -> list[DeckContact]:
    """Return the contacts of a validated scene; ``surfaces`` are given by "body.surface"."""
    found = []
    for name, spec in contacts.items():
        area = surfaces[spec.a].area
        p = float(spec.p or 0.0) if spec.P is None else spec.P / area
        sides = set_name(spec.a), set_name(spec.b)
        found.append(DeckContact(f"{name}-interaction", *sides, p, float(spec.mu)))
    return found


def contact_lines(contacts: list[DeckContact], closure: float) -> Iterator[str]:
    """Yield surface interactions with linear laws, and contact pairs with a closure (m)."""
    for each in contacts:
        yield keyword("SURFACE INTERACTION", NAME=each.interaction)
        yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
        yield numbers(each.stiffness)
        if each.mu:
            yield from ("*FRICTION", numbers(MORE_FRICTION * each.mu, STICK * each.stiffness))
        yield keyword("CONTACT PAIR", INTERACTION=each.interaction, TYPE="SURFACE TO SURFACE")
        yield f"{each.slave}, {each.master}"
        overlap = numbers(-closure)  # replaces the distances of the nodes
        yield keyword("CLEARANCE", MASTER=each.master, SLAVE=each.slave, VALUE=overlap)


@dataclass(frozen=True)
class RigidMotion:
    """A rigid body velocity: a unit translation, or a rotation with unit speed at ``radius``."""

    direction: AlongVector | Circumferential
    radius: float = 1.0

    def at(self, x: Floats) -> Floats:
        """Return the velocities at points, (n, 3)."""
        direction = self.direction
        if isinstance(direction, AlongVector):
            return np.broadcast_to(_unit(direction.vector), x.shape)
        axis = _unit(direction.circumferential_about)
        return np.cross(axis, x - np.asarray(direction.origin)) / self.radius


def moving_bodies(
    contacts: Mapping[str, ContactSpec],
    bodies: Mapping[str, DeckBody],
    surfaces: Mapping[str, Surface],
) -> dict[str, RigidMotion]:
    """Return the motions of the moving bodies, by name; all others are at rest."""
    motions: dict[str, RigidMotion] = {}
    sliding = {name: contact for name, contact in contacts.items() if contact.mu}
    resting = {contact.a.split(".")[0] for contact in sliding.values()}
    for name, contact in sliding.items():
        direction, field = contact.friction_direction_on_a, f"contacts.{name}"
        body = contact.b.split(".")[0]
        if body in resting:
            allowed = "a body that is side b of every contact with friction, or of none"
            raise InputError(f"{field}.b", contact.b, allowed)
        field = f"{field}.friction_direction_on_a"
        if not isinstance(direction, AlongVector | Circumferential):
            allowed = "a vector, or circumferential: that of a rigid motion"
            raise InputError(field, direction, allowed)
        before = motions.get(body)
        if before is not None and before.direction != direction:
            allowed = f"the same for all contacts of which {body} is side b"
            raise InputError(field, direction, allowed)
        motion = RigidMotion(direction)
        if isinstance(direction, Circumferential):
            owner, surface = contact.a.split(".")
            x = bodies[owner].points[bodies[owner].nodes_of(surface)]
            radius = float(np.linalg.norm(motion.at(x), axis=1).min())
            motion = RigidMotion(direction, min(radius, before.radius if before else np.inf))
        motions[body] = motion
        for side in (contact.a, contact.b):
            points = surfaces[side].gauss_points(2)
            velocity = motion.at(points.x)
            across = np.abs(np.einsum("ij,ij->i", points.normal, velocity))
            if (across > _TANGENT * np.linalg.norm(velocity, axis=1)).any():
                allowed = f"tangential to {side} everywhere, so that the sides stay in contact"
                raise InputError(field, direction, allowed)
    return motions


def _unit(vector: tuple[float, ...]) -> Floats:
    direction = np.asarray(vector, dtype=float)
    return direction / np.linalg.norm(direction)
