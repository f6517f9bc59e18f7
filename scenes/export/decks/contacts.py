"""Contacts of a deck: surface interactions, pairs, and how they are closed before modes are sought.

A scene knows its contacts to be closed. A deck has to close them: the sides overlap by a closure so
small that nothing deforms, and all pressures are the contact stiffness times that closure.

Friction pushes side a against the velocity of a relative to b: where side a rests, side b moves in
the direction of friction on a.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cea.contact.friction import AlongVector, Circumferential, FrictionDirection
from cea.errors import InputError
from cea.mesh import Floats
from scenes.export.decks.bodies import DeckBody, set_name
from scenes.export.decks.lines import keyword, number, numbers
from scenes.spec.contact import ContactSpec


@dataclass(frozen=True)
class DeckContact:
    """A contact as decks have it.

    Parameters
    ----------
    name
        Name in the scene.
    spec
        What the scene says of it; side a is the slave, where integration points lie.
    stiffness
        Contact stiffness p (N/m^3), uniform.
    mu
        Friction coefficient.
    closure
        How far the sides overlap (m).
    """

    name: str
    spec: ContactSpec
    stiffness: float
    mu: float
    closure: float

    @property
    def interaction(self) -> str:
        """Name of its surface interaction."""
        return f"{self.name}-interaction"

    @property
    def slave(self) -> str:
        """Name of the surface that is side a."""
        return set_name(self.spec.a)

    @property
    def master(self) -> str:
        """Name of the surface that is side b."""
        return set_name(self.spec.b)

    def behaviour_lines(self, friction: list[float]) -> list[str]:
        """Its surface interaction: a linear law, and the numbers of friction where there is any."""
        friction_lines = [keyword("FRICTION"), numbers(friction)] if self.mu else []
        return [
            keyword("SURFACE INTERACTION", NAME=self.interaction),
            "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
            number(self.stiffness),
            *friction_lines,
        ]

    def pair_lines(self, *parameters: str) -> list[str]:
        """The pair, slave first."""
        options = ", ".join(["TYPE=SURFACE TO SURFACE", *parameters])
        return [f"*CONTACT PAIR, INTERACTION={self.interaction}, {options}", self._sides]

    def clearance_line(self) -> str:
        """The overlap in the place of whatever distance the nodes have."""
        value = number(-self.closure)
        return keyword("CLEARANCE", MASTER=self.master, SLAVE=self.slave, VALUE=value)

    @property
    def _sides(self) -> str:
        return f"{self.slave}, {self.master}"


def deck_contacts(
    contacts: Mapping[str, ContactSpec], bodies: Mapping[str, DeckBody], relative_closure: float
) -> list[DeckContact]:
    """Contacts of a scene that was checked before."""
    points = np.concatenate([body.mesh.points for body in bodies.values()])
    closure = relative_closure * float(np.ptp(points, axis=0).max())
    return [
        DeckContact(name, spec, _stiffness(name, spec, bodies), float(spec.mu), closure)
        for name, spec in contacts.items()
    ]


def _stiffness(name: str, spec: ContactSpec, bodies: Mapping[str, DeckBody]) -> float:
    """p, or P over the area of side a."""
    if spec.P is None:
        return float(spec.p or 0.0)
    body, surface = spec.a.split(".")
    area = bodies[body].area_of(surface)
    if not area > 0:
        raise InputError(f"contacts.{name}.a", spec.a, "a surface with an area")
    return spec.P / area


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
