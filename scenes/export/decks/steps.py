"""The steps of a deck for each program: steady sliding, then frequencies about it.

Neither program computes that state itself. It is imposed by static steps with all nodes fixed, so
that all contacts keep the given overlap and nothing deforms; the frequency step then releases all
nodes except the supports. The programs differ in:

- closure, relative to the size of the bodies: 1e-12 in CalculiX, since slip is then small and
  rounding of coordinates is smaller; 1e-7 in Abaqus.
- sliding: CalculiX displaces the moving bodies as rigid bodies, far enough for every point to
  slip. Friction then equals the limit up to rounding, and the frequency step would treat many
  points as sticking: for the disc and pad it then finds no instability. The static step therefore
  has twice the friction; with that of the scene all points are then beyond the limit. Normal to
  the slip direction CalculiX adds the stick stiffness, which the scene does not have; it is chosen
  small. Abaqus gives the material a velocity (``*MOTION``), so that the mesh is at rest; friction
  then gives unsymmetric terms, and no damping.
- eigenvalues: CalculiX computes complex ones if its matrices are unsymmetric; Abaqus projects on a
  basis of modes without friction, with more modes and higher frequencies than requested.

The deck of Abaqus/Standard follows its manual.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from cea.contact.friction import Circumferential
from scenes.export.decks.bodies import DeckBody
from scenes.export.decks.contacts import MORE_FRICTION, STICK, DeckContact, RigidMotion
from scenes.export.decks.model import boundary_lines, comments, keyword, numbers, table

CLOSURE = {"calculix": 1e-12, "abaqus": 1e-7}
"""Closure, relative to the size of the bodies."""
_BEYOND = 2.0
"""Imposed slip, relative to that at which a point begins to slip."""
BASIS = 2
"""Size and highest frequency of the modal basis of Abaqus, relative to those requested."""


@dataclass(frozen=True)
class Deck:
    """Contents of a deck."""

    bodies: Mapping[str, DeckBody]
    contacts: list[DeckContact]
    motions: Mapping[str, RigidMotion]  # of the moving bodies
    modes: int  # requested number
    max_frequency: float  # upper end of the window (Hz)

    def closure(self, program: str) -> float:
        """Return the overlap of the sides (m)."""
        points = np.concatenate([body.points for body in self.bodies.values()])
        return CLOSURE[program] * float(np.ptp(points, axis=0).max())


def _friction_lines(contacts: list[DeckContact], stick: float | None) -> Iterator[str]:
    """Yield the lines that change friction to that of the scene from this step on."""
    for each in contacts:
        if each.mu:
            yield keyword("CHANGE FRICTION", INTERACTION=each.interaction)
            values = [each.mu] if stick is None else [each.mu, stick * each.stiffness]
            yield from ("*FRICTION", numbers(*values))


def calculix_steps(deck: Deck) -> Iterator[str]:
    """Yield a static step that closes and slides the contacts, and the frequency step."""
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
    """Return a line for each component of the displacements of all nodes, (n_nodes, 3)."""
    nodes = np.repeat(np.arange(len(vectors)) + body.first_node, 3)
    components = np.tile([1, 2, 3], len(vectors))
    values = vectors.ravel() + 0.0  # no negative zeros
    rows = np.column_stack([nodes, components, components, values])
    return table(rows, "%d,%d,%d,%.13E")


def abaqus_steps(deck: Deck) -> Iterator[str]:
    """Yield static steps that close and slide the contacts, real modes, and complex modes."""
    if deck.contacts:
        yield from comments(
            ["Sides closed, all nodes fixed: check that each contact has pressure (CPRESS)."]
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
    """Yield the velocity of a body, with unit sliding speed at its slowest point."""
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
"""Functions that yield the steps for each program."""
