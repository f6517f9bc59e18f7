"""The deck of Abaqus/Standard: frequencies, then complex frequencies about steady sliding.

Written after its manual. Static steps make the state of steady sliding. Every node is held in
them, so that all contacts keep the overlap they are given whatever supports leave free; motion of
the sliding body is a velocity of its material (``*MOTION``), so that its mesh rests. Friction then
gives unsymmetric terms, and no damping. The frequency step frees all but the supports. Its modes
are the basis in which complex frequencies are sought: more, and further, than those asked for.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from cea.contact.friction import Circumferential
from scenes.export.decks.bodies import DeckBody
from scenes.export.decks.contacts import DeckContact, RigidMotion, deck_contacts, moving_bodies
from scenes.export.decks.lines import comments, joined, keyword, number, numbers
from scenes.export.decks.supports import boundary_lines, displacement_lines, local_frames
from scenes.spec.reading import ComplexEigenvalueAnalysis, Scene

RELATIVE_CLOSURE = 1e-7
"""Closure over the size of the bodies."""
BASIS = 2
"""Modes of the basis over those that are asked for, and its highest frequency over theirs."""


def abaqus_text(
    scene: Scene, bodies: Mapping[str, DeckBody], model: str, modes: int, told: list[str]
) -> str:
    """Text of the deck; parameters as for :func:`scenes.export.decks.calculix.calculix_text`."""
    contacts = deck_contacts(scene.contacts, bodies, RELATIVE_CLOSURE)
    motions = moving_bodies(scene.contacts, bodies)
    heading = [
        "*HEADING",
        model.removesuffix("_model.inp"),
        *comments(told),
        f"*INCLUDE, INPUT={model}",
        *boundary_lines(bodies),
    ]
    steps = [_static_steps(contacts, bodies, motions)] if contacts else []
    free = list(boundary_lines(bodies, OP="NEW")) if contacts else []
    if motions:
        wanted = _range(BASIS * modes, BASIS * _top(scene))
        steps += [_frequency_step(wanted, free), _complex_step(_range(modes, _top(scene)))]
    else:
        steps.append(_frequency_step(_range(modes, _top(scene)), free))
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


def _range(modes: int, top: float) -> str:
    """So many modes up to a frequency (Hz), and none too low."""
    return f"{modes}, , {number(top)}"


def _static_steps(
    contacts: list[DeckContact], bodies: Mapping[str, DeckBody], motions: Mapping[str, RigidMotion]
) -> list[str]:
    """Sides closed by their overlap, then friction with the velocity of what slides."""
    lines = [
        *comments(["Sides closed, all nodes held: look that each contact has pressure (CPRESS)."]),
        *("*STEP, UNSYMM=YES", "*STATIC", "1., 1.", "*BOUNDARY, OP=NEW"),
        *(f"{name}, 1, 3" for name in bodies),
        "*END STEP",
    ]
    if not motions:
        return lines
    return [
        *lines,
        *comments(["Friction of steady sliding: side b moves, in its direction on side a."]),
        *("*STEP, UNSYMM=YES", "*STATIC", "1., 1."),
        *(line for contact in contacts if contact.mu for line in _friction_lines(contact)),
        *(line for name, motion in motions.items() for line in _motion_lines(bodies[name], motion)),
        "*END STEP",
    ]


def _frequency_step(wanted: str, supports: list[str]) -> list[str]:
    """Modes without friction, with the supports where they are not those of the step before."""
    return ["*STEP", "*FREQUENCY, EIGENSOLVER=LANCZOS", wanted, *supports, "*END STEP"]


def _friction_lines(contact: DeckContact) -> list[str]:
    return [
        keyword("CHANGE FRICTION", INTERACTION=contact.interaction),
        keyword("FRICTION"),
        number(contact.mu),
    ]


def _motion_lines(body: DeckBody, motion: RigidMotion) -> Iterator[str]:
    """Velocity of a body: of one where it slides slowest."""
    direction = motion.direction
    if isinstance(direction, Circumferential):
        yield "*MOTION, ROTATION, TYPE=VELOCITY"
        origin = np.asarray(direction.origin)
        end = origin + np.asarray(direction.circumferential_about)
        yield f"{body.name}, {numbers([1 / motion.radius, *origin, *end])}"
        return
    yield "*MOTION, TRANSLATION, TYPE=VELOCITY"
    if local_frames(body):  # components of a translation are those of the frames of its nodes
        yield from displacement_lines(body, motion.at(body.mesh.points))
    else:
        vector = motion.at(np.zeros((1, 3)))[0]
        yield from (f"{body.name}, {i}, {i}, {number(v)}" for i, v in enumerate(vector, 1) if v)


def _complex_step(wanted: str) -> list[str]:
    return [
        *comments(["Positive real parts are unstable."]),
        "*STEP, UNSYMM=YES",
        "*COMPLEX FREQUENCY, FRICTION DAMPING=NO",
        wanted,
        "*END STEP",
    ]
