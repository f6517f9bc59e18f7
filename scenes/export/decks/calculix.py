"""Contacts of a deck, and its steps: steady sliding, then frequencies about it.

In a scene the contacts are closed by assumption. A deck has to close them: the sides overlap by a
closure that is so small that nothing deforms; all pressures are the contact stiffness times it.

Friction on side a acts against the velocity of a relative to b: if side a is at rest, side b moves
in the direction of friction on a.

CalculiX does not compute steady sliding itself. It is imposed by a static step with all nodes
fixed, so that all contacts keep the given overlap and nothing deforms; the frequency step then
releases all nodes except the supports.

The static step displaces the moving bodies as rigid bodies, far enough for every point to slip.
Friction then equals the limit up to rounding, and the frequency step would treat many points as
sticking: for the disc and pad it then finds no instability. The static step therefore has twice the
friction; with that of the scene all points are then beyond the limit. Normal to the slip direction
CalculiX adds the stick stiffness, which the scene does not have; it is chosen small.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from cea.contact.laws import AlongVector, Circumferential
from cea.errors import InputError
from cea.surface import Surface
from scenes.export.decks.model import (
    DeckBody,
    boundary_lines,
    comments,
    keyword,
    numbers,
    set_name,
    table,
)
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

_CLOSURE = 1e-12
"""Closure, relative to the size of the bodies: slip is then small and rounding of coordinates is
smaller."""
_STICK = 1e-5
"""Stick stiffness, relative to the contact stiffness."""
_MORE_FRICTION = 2.0
"""Friction coefficient of the static step, relative to that of the scene."""
_BEYOND = 2.0
"""Imposed slip, relative to that at which a point begins to slip."""
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


def deck_lines(
    scene: Scene,
    bodies: Mapping[str, DeckBody],
    surfaces: Mapping[str, Surface],
    model: str,
    modes: int,
) -> Iterator[str]:
    """Yield the lines of the deck of a validated scene, which includes the file ``model``.

    ``surfaces`` are given by "body.surface"; ``modes`` is the number of modes to compute.
    """
    contacts = []
    for name, spec in scene.contacts.items():
        p = float(spec.p or 0.0) if spec.P is None else spec.P / surfaces[spec.a].area
        sides = set_name(spec.a), set_name(spec.b)
        contacts.append(DeckContact(f"{name}-interaction", *sides, p, float(spec.mu)))
    motions = _moving_bodies(scene.contacts, bodies, surfaces)
    points = np.concatenate([body.points for body in bodies.values()])
    closure = _CLOSURE * float(np.ptp(points, axis=0).max())
    yield from comments(_about(scene, bodies))
    yield f"*INCLUDE, INPUT={model}"
    yield from boundary_lines(bodies)
    yield from _contact_lines(contacts, closure)
    yield from _step_lines(bodies, contacts, motions, closure, modes)


def _about(scene: Scene, bodies: Mapping[str, DeckBody]) -> Iterator[str]:
    """Yield the comments at the head of a deck."""
    yield f"{scene.name}, for CalculiX. Units are those of the scene."
    for name, body in bodies.items():
        yield f"{name}: {len(body.points)} nodes, {len(body.elements)} {body.element_type}"
    for name, contact in scene.contacts.items():
        yield (
            f"Contact {name}: slave {contact.a}, master {contact.b}, penalty on the surface of the "
            f"slave instead of the formulation {contact.formulation.method}."
        )


def _contact_lines(contacts: list[DeckContact], closure: float) -> Iterator[str]:
    """Yield surface interactions with linear laws, and contact pairs with a closure (m)."""
    for each in contacts:
        yield keyword("SURFACE INTERACTION", NAME=each.interaction)
        yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
        yield numbers(each.stiffness)
        if each.mu:
            yield from ("*FRICTION", numbers(_MORE_FRICTION * each.mu, _STICK * each.stiffness))
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


def _moving_bodies(
    contacts: Mapping[str, ContactSpec],
    bodies: Mapping[str, DeckBody],
    surfaces: Mapping[str, Surface],
) -> dict[str, RigidMotion]:
    """Return the motions of the moving bodies, by name; all others are at rest."""
    motions: dict[str, RigidMotion] = {}
    sliding = {name: contact for name, contact in contacts.items() if contact.mu}
    resting = {contact.sides[0][0] for contact in sliding.values()}
    for name, contact in sliding.items():
        direction, field = contact.friction_direction_on_a, f"contacts.{name}"
        (owner, surface), (body, _) = contact.sides
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


def _step_lines(
    bodies: Mapping[str, DeckBody],
    contacts: list[DeckContact],
    motions: Mapping[str, RigidMotion],
    closure: float,
    modes: int,
) -> Iterator[str]:
    """Yield a static step that closes and slides the contacts, and the frequency step."""
    if contacts:
        yield from comments(["Sides closed and sliding; nothing deforms."])
        yield from ("*STEP", "*STATIC, DIRECT", "1., 1.", "*BOUNDARY, OP=NEW")
        largest = max(each.mu for each in contacts) * closure
        slip = _BEYOND * _MORE_FRICTION * largest / _STICK
        for name, body in bodies.items():
            if name in motions:
                yield from _displacement_lines(body, slip * motions[name].at(body.points))
            else:
                yield f"{name}, 1, 3"
        for each in contacts:
            yield from (f"*CONTACT PRINT, MASTER={each.master}, SLAVE={each.slave}", "CF")
        yield "*END STEP"
        yield from comments(
            ["Modes about that state, with the supports and friction of the scene."]
        )
    yield "*STEP, PERTURBATION" if contacts else "*STEP"
    for each in contacts:
        if each.mu:
            yield keyword("CHANGE FRICTION", INTERACTION=each.interaction)
            yield from ("*FRICTION", numbers(each.mu, _STICK * each.stiffness))
    yield from ("*FREQUENCY, STORAGE=YES", str(modes))
    if contacts:
        yield from boundary_lines(bodies, OP="NEW")
    yield from ("*NODE FILE", "U", "*END STEP")


def _displacement_lines(body: DeckBody, vectors: np.ndarray) -> list[str]:
    """Return a line for each component of the displacements of all nodes, (n_nodes, 3)."""
    nodes = np.repeat(np.arange(len(vectors)) + body.first_node, 3)
    components = np.tile([1, 2, 3], len(vectors))
    values = vectors.ravel() + 0.0  # no negative zeros
    rows = np.column_stack([nodes, components, components, values])
    return table(rows, "%d,%d,%d,%.13E")


def _unit(vector: tuple[float, ...]) -> Floats:
    direction = np.asarray(vector, dtype=float)
    return direction / np.linalg.norm(direction)
