"""The deck of Abaqus/Standard: frequencies, then complex frequencies about steady sliding.

Written after its manual. Motion of the sliding body is given as a velocity of its material
(``*MOTION``), so that its mesh rests; friction then gives unsymmetric terms, and no damping.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from cea.contact.friction import AlongVector
from scenes.deck.bodies import DeckBody
from scenes.deck.contacts import DeckContact, deck_contacts
from scenes.deck.lines import comments, joined, keyword, number, numbers
from scenes.deck.sliding import RigidMotion, moving_bodies
from scenes.deck.supports import boundary_lines
from scenes.read import Scene
from scenes.spec.analysis import ComplexEigenvalueAnalysis

RELATIVE_CLOSURE = 1e-7
"""Closure over the size of the bodies: what deforms moves no frequency."""


def abaqus_text(
    scene: Scene, bodies: Mapping[str, DeckBody], model: str, modes: int, told: list[str]
) -> str:
    """Text of the deck; parameters as for :func:`scenes.deck.calculix.calculix_text`.

    Raises
    ------
    InputError
        When no motion makes friction act as the scene says.
    """
    contacts = deck_contacts(scene.contacts, bodies, RELATIVE_CLOSURE)
    motions = moving_bodies(scene.contacts, bodies)
    heading = [
        "*HEADING",
        model.removesuffix("_model.inp"),
        *comments(told),
        f"*INCLUDE, INPUT={model}",
        *boundary_lines(bodies),
    ]
    steps = [_static_step(contacts, motions)] if contacts else []
    top = f", , {number(_top(scene))}"
    frequency = ["*STEP", "*FREQUENCY, EIGENSOLVER=LANCZOS", f"{modes}{top}", "*END STEP"]
    if motions:
        steps += [frequency, _complex_step(modes, top)]
    else:
        steps.append(frequency)
    behaviour = [line for contact in contacts for line in _contact_lines(contact)]
    return joined([heading, behaviour, *map(list, steps)])


def _top(scene: Scene) -> float:
    assert isinstance(scene.analysis, ComplexEigenvalueAnalysis)
    return scene.analysis.max_frequency


def _contact_lines(contact: DeckContact) -> list[str]:
    return [
        *contact.behaviour_lines([0.0]),
        *contact.pair_lines("SMALL SLIDING"),
        contact.clearance_line(),
    ]


def _static_step(contacts: list[DeckContact], motions: Mapping[str, RigidMotion]) -> list[str]:
    """Sides closed by their overlap, then friction with the velocity of what slides."""
    lines = [
        *comments(["Sides closed: look that all of each contact is (COPEN, CPRESS)."]),
        *("*STEP, UNSYMM=YES", "*STATIC", "1., 1.", "*END STEP"),
    ]
    if not motions:
        return lines
    return [
        *lines,
        *comments(["Friction of steady sliding: side b moves, in its direction on side a."]),
        *("*STEP, UNSYMM=YES", "*STATIC", "1., 1."),
        *(line for contact in contacts if contact.mu for line in _friction_lines(contact)),
        *(line for name, motion in motions.items() for line in _motion_lines(name, motion)),
        "*END STEP",
    ]


def _friction_lines(contact: DeckContact) -> list[str]:
    return [
        keyword("CHANGE FRICTION", INTERACTION=contact.interaction),
        keyword("FRICTION"),
        number(contact.mu),
    ]


def _motion_lines(body: str, motion: RigidMotion) -> Iterator[str]:
    """Velocity of a body: of one where it slides slowest."""
    direction = motion.direction
    if isinstance(direction, AlongVector):
        yield "*MOTION, TRANSLATION, TYPE=VELOCITY"
        vector = motion.at(np.zeros((1, 3)))[0]
        yield from (f"{body}, {i}, {i}, {number(v)}" for i, v in enumerate(vector, 1) if v)
    else:
        yield "*MOTION, ROTATION, TYPE=VELOCITY"
        origin = np.asarray(direction.origin)
        end = origin + np.asarray(direction.circumferential_about)
        yield f"{body}, {numbers([1 / motion.radius, *origin, *end])}"


def _complex_step(modes: int, top: str) -> list[str]:
    return [
        *comments(["Positive real parts are unstable."]),
        "*STEP, UNSYMM=YES",
        "*COMPLEX FREQUENCY, FRICTION DAMPING=NO",
        f"{modes}{top}",
        "*END STEP",
    ]
