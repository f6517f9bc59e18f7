"""How bodies move past each other in a deck: the motion that makes friction act as the scene says.

Friction pushes side a against the velocity of a relative to b: where side a rests, side b moves in
the direction of friction on a.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cea.contact.friction import AlongVector, Circumferential, FrictionDirection
from cea.errors import InputError
from cea.mesh import Floats
from scenes.export.decks.bodies import DeckBody
from scenes.spec.contact import ContactSpec

_TANGENT = 1e-6
"""Part of a velocity along the normal that counts as none."""


@dataclass(frozen=True)
class RigidMotion:
    """A rigid velocity, of size one where it is slowest."""

    direction: AlongVector | Circumferential
    radius: float = 1.0

    def at(self, x: Floats) -> Floats:
        """Velocities at points, (n, 3)."""
        points = _in_space(x)
        direction = self.direction
        if isinstance(direction, AlongVector):
            vector = _unit(direction.vector)
            return np.broadcast_to(_in_space(vector[None])[0], points.shape)
        axis = _unit(direction.circumferential_about)
        return np.cross(axis, points - np.asarray(direction.origin)) / self.radius


def moving_bodies(
    contacts: Mapping[str, ContactSpec], bodies: Mapping[str, DeckBody]
) -> dict[str, RigidMotion]:
    """Motions of the bodies that move, by name; all others rest."""
    found: dict[str, tuple[str, FrictionDirection]] = {}
    motions: dict[str, RigidMotion] = {}
    resting = {c.a.split(".")[0] for c in contacts.values() if c.mu}
    for name, contact in contacts.items():
        direction = contact.friction_direction_on_a
        if not contact.mu or direction is None:
            continue
        field = f"contacts.{name}.friction_direction_on_a"
        body = contact.b.split(".")[0]
        if body in resting:
            allowed = "a body that is side b of every contact with friction, or of none"
            raise InputError(f"contacts.{name}.b", contact.b, allowed)
        if body in found and found[body][1] != direction:
            allowed = f"that of contacts.{found[body][0]}, of which {body} is side b too"
            raise InputError(field, direction, allowed)
        if not isinstance(direction, AlongVector | Circumferential):
            allowed = "a vector, or circumferential: a rigid motion makes it"
            raise InputError(field, direction, allowed)
        found[body] = name, direction
        motion = _motion(direction, [bodies[side.split(".")[0]] for side in (contact.a,)], contact)
        slowest = motions[body].radius if body in motions else np.inf
        motions[body] = RigidMotion(direction, min(motion.radius, slowest))
        for side in (contact.a, contact.b):
            _check_tangent(field, motion, bodies, side)
    return motions


def _motion(
    direction: AlongVector | Circumferential, sides: list[DeckBody], contact: ContactSpec
) -> RigidMotion:
    """Motion whose speed at the nodes of side a is one or more."""
    if isinstance(direction, AlongVector):
        return RigidMotion(direction)
    (body,) = sides
    x = body.mesh.points[body.nodes_of(contact.a.split(".")[1])]
    radius = np.linalg.norm(RigidMotion(direction).at(x), axis=1).min()
    return RigidMotion(direction, float(radius))


def _check_tangent(
    field: str, motion: RigidMotion, bodies: Mapping[str, DeckBody], side: str
) -> None:
    """Refuse a motion that takes a side off, or into, the other."""
    body, surface = bodies[side.split(".")[0]], side.split(".")[1]
    x = body.mesh.points[body.mesh.surfaces[surface]].mean(axis=1)
    normal = body.area_vectors(surface).sum(axis=1)
    velocity = motion.at(x)[:, : body.mesh.dim]
    across = np.abs(np.einsum("ij,ij->i", normal, velocity))
    sizes = np.linalg.norm(normal, axis=1) * np.linalg.norm(velocity, axis=1)
    if (across > _TANGENT * sizes).any():
        allowed = f"along {side} everywhere, so that the sides stay together as they slide"
        raise InputError(field, motion.direction, allowed)


def _in_space(x: Floats) -> Floats:
    points = np.zeros((len(x), 3))
    points[:, : x.shape[1]] = x
    return points


def _unit(vector: tuple[float, ...]) -> Floats:
    direction = np.asarray(vector, dtype=float)
    return direction / np.linalg.norm(direction)
