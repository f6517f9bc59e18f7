"""The steps of a deck, for each program: steady sliding, then frequencies about it.

Neither program knows that state. Static steps make it, in which every node is held, so that all
contacts keep the overlap they are given and nothing deforms; the frequency step then frees all but
the supports. What differs:

- closure over the size of the bodies: 1e-12 in CalculiX, as slip is small with it and rounding of
  coordinates smaller; 1e-7 in Abaqus.
- sliding: CalculiX displaces the bodies that move as rigid bodies, far enough for every point to
  slip. Its friction then lies on the limit to rounding, and the frequency step would find many
  points to stick: of the disc and pad it then finds no instability. So the static step has twice
  the friction, and with that of the scene all points are beyond the limit. Across the direction of
  slip it gives a point its stick stiffness, which the scene has not: it is chosen small. Abaqus
  gives the material a velocity (``*MOTION``), so that the mesh rests; friction then gives
  unsymmetric terms, and no damping.
- eigenvalues: CalculiX finds complex ones where its matrices are unsymmetric; Abaqus seeks them in
  a basis of modes without friction: more, and further, than those asked for.

The deck of Abaqus/Standard is written after its manual.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from cea.contact.friction import Circumferential
from scenes.export.decks.bodies import DeckBody
from scenes.export.decks.contacts import MORE_FRICTION, STICK, DeckContact, RigidMotion
from scenes.export.decks.model import boundary_lines, comments, keyword, numbers, table

CLOSURE = {"calculix": 1e-12, "abaqus": 1e-7}
"""Closure over the size of the bodies."""
_BEYOND = 2.0
"""Slip over that at which a point begins to slip."""
BASIS = 2
"""Modes of the basis of Abaqus over those that are asked for, and its highest frequency."""


@dataclass(frozen=True)
class Deck:
    """What a deck is made of."""

    bodies: Mapping[str, DeckBody]
    contacts: list[DeckContact]
    motions: Mapping[str, RigidMotion]  # of the bodies that move
    modes: int  # number that is asked for
    max_frequency: float  # upper end of the window (Hz)

    def closure(self, program: str) -> float:
        """How far the sides overlap (m)."""
        points = np.concatenate([body.points for body in self.bodies.values()])
        return CLOSURE[program] * float(np.ptp(points, axis=0).max())


def _friction_lines(contacts: list[DeckContact], stick: float | None) -> Iterator[str]:
    """The friction of the scene, from a step on."""
    for each in contacts:
        if each.mu:
            yield keyword("CHANGE FRICTION", INTERACTION=each.interaction)
            values = [each.mu] if stick is None else [each.mu, stick * each.stiffness]
            yield from ("*FRICTION", numbers(*values))


def calculix_steps(deck: Deck) -> Iterator[str]:
    """Sides closed and sliding, then modes."""
    if deck.contacts:
        yield from comments(["Sides closed and sliding; nothing deforms."])
        yield from ("*STEP", "*STATIC, DIRECT", "1., 1.", "*BOUNDARY, OP=NEW")
        largest = max(each.mu for each in deck.contacts) * deck.closure("calculix")
        slip = _BEYOND * MORE_FRICTION * largest / STICK
        for name, body in deck.bodies.items():
            if name in deck.motions:
                yield from _displacement_lines(body, slip * deck.motions[name].at(body.points))
            else:
                yield f"{name}, 1, 3"
        for each in deck.contacts:
            yield from (f"*CONTACT PRINT, MASTER={each.master}, SLAVE={each.slave}", "CF")
        yield "*END STEP"
        yield from comments(
            ["Modes about that state, with the supports and friction of the scene."]
        )
    yield "*STEP, PERTURBATION" if deck.contacts else "*STEP"
    yield from _friction_lines(deck.contacts, STICK)
    yield from ("*FREQUENCY, STORAGE=YES", str(deck.modes))
    if deck.contacts:
        yield from boundary_lines(deck.bodies, OP="NEW")
    yield from ("*NODE FILE", "U", "*END STEP")


def _displacement_lines(body: DeckBody, vectors: np.ndarray) -> list[str]:
    """A line for each component of displacements of all nodes, (n_nodes, 3)."""
    nodes = np.repeat(np.arange(len(vectors)) + body.first_node, 3)
    components = np.tile([1, 2, 3], len(vectors))
    values = vectors.ravel() + 0.0  # no negative zeros
    rows = np.column_stack([nodes, components, components, values])
    return table(rows, "%d,%d,%d,%.13E")


def abaqus_steps(deck: Deck) -> Iterator[str]:
    """Sides closed, then sliding; modes without friction, then complex ones."""
    if deck.contacts:
        yield from comments(
            ["Sides closed, all nodes held: look that each contact has pressure (CPRESS)."]
        )
        yield from ("*STEP, UNSYMM=YES", "*STATIC", "1., 1.", "*BOUNDARY, OP=NEW")
        yield from (f"{name}, 1, 3" for name in deck.bodies)
        yield "*END STEP"
    if deck.motions:
        yield from comments(
            ["Friction of steady sliding: side b moves, in its direction on side a."]
        )
        yield from ("*STEP, UNSYMM=YES", "*STATIC", "1., 1.")
        yield from _friction_lines(deck.contacts, None)
        for name, motion in deck.motions.items():
            yield from _motion_lines(name, motion)
        yield "*END STEP"
    more = BASIS if deck.motions else 1
    yield from ("*STEP", "*FREQUENCY, EIGENSOLVER=LANCZOS")
    yield f"{more * deck.modes}, , {numbers(more * deck.max_frequency)}"
    if deck.contacts:
        yield from boundary_lines(deck.bodies, OP="NEW")
    yield "*END STEP"
    if deck.motions:
        yield from comments(["Positive real parts are unstable."])
        yield from ("*STEP, UNSYMM=YES", "*COMPLEX FREQUENCY, FRICTION DAMPING=NO")
        yield from (f"{deck.modes}, , {numbers(deck.max_frequency)}", "*END STEP")


def _motion_lines(body: str, motion: RigidMotion) -> Iterator[str]:
    """Velocity of a body: of one where it slides slowest."""
    direction = motion.direction
    if isinstance(direction, Circumferential):
        yield "*MOTION, ROTATION, TYPE=VELOCITY"
        origin = np.asarray(direction.origin)
        end = origin + np.asarray(direction.circumferential_about)
        yield f"{body}, {numbers(1 / motion.radius, *origin, *end)}"
        return
    yield "*MOTION, TRANSLATION, TYPE=VELOCITY"
    (vector,) = motion.at(np.zeros((1, 3)))
    yield from (f"{body}, {i}, {i}, {numbers(v)}" for i, v in enumerate(vector, 1) if v)


STEPS = {"calculix": calculix_steps, "abaqus": abaqus_steps}
"""What writes the steps of each program."""
