"""The deck of CalculiX: frequencies, or complex frequencies where sides rub.

CalculiX knows no steady sliding. A static step makes it: every node of the model is held but those
of the bodies that move, which are displaced as rigid bodies, far enough for every point to slip.
The frequency step then frees all but the supports. Friction makes its matrices unsymmetric, and the
eigenvalues complex.

Where a point slipped, its friction lies on the limit to rounding, and the frequency step would find
many points to stick: of the disc and pad it then finds no instability. So the static step has twice
the friction, and with that of the scene all points are beyond the limit. Across the direction of
slip CalculiX gives a point its stick stiffness, which the scene has not: it is chosen small.
"""

from collections.abc import Iterator, Mapping

from scenes.export.decks.bodies import DeckBody
from scenes.export.decks.contacts import DeckContact, RigidMotion, deck_contacts, moving_bodies
from scenes.export.decks.lines import comments, joined, keyword, numbers
from scenes.export.decks.supports import boundary_lines, displacement_lines
from scenes.spec.reading import Scene

RELATIVE_CLOSURE = 1e-12
"""Closure over the size of the bodies: slip is small with it, rounding of coordinates smaller."""
STICK = 1e-5
"""Stick stiffness over contact stiffness."""
MORE_FRICTION = 2.0
"""Friction of the static step over that of the scene."""
_BEYOND = 2.0
"""Slip over that at which a point begins to slip."""


def calculix_text(
    scene: Scene, bodies: Mapping[str, DeckBody], model: str, modes: int, told: list[str]
) -> str:
    """Text of the deck."""
    contacts = deck_contacts(scene.contacts, bodies, RELATIVE_CLOSURE)
    heading = [*comments(told), f"*INCLUDE, INPUT={model}", *boundary_lines(bodies)]
    if not contacts:
        return joined([heading, _frequency_lines(modes)])
    motions = moving_bodies(scene.contacts, bodies)
    return joined(
        [
            heading,
            [line for contact in contacts for line in _contact_lines(contact)],
            list(_static_step(contacts, bodies, motions)),
            list(_complex_step(contacts, bodies, modes)),
        ]
    )


def _frequency_lines(modes: int) -> list[str]:
    return ["*STEP", "*FREQUENCY, STORAGE=YES", str(modes), "*NODE FILE", "U", "*END STEP"]


def _contact_lines(contact: DeckContact) -> list[str]:
    friction = [MORE_FRICTION * contact.mu, STICK * contact.stiffness]
    return [
        *contact.behaviour_lines(friction),
        *contact.pair_lines(),
        contact.clearance_line(),
    ]


def _static_step(
    contacts: list[DeckContact], bodies: Mapping[str, DeckBody], motions: Mapping[str, RigidMotion]
) -> Iterator[str]:
    """Every node is held or displaced; points slip, and bear the same pressure everywhere."""
    largest = max(contact.mu * contact.closure for contact in contacts)
    slip = _BEYOND * MORE_FRICTION * largest / STICK
    yield from comments(["Sides closed and sliding; nothing deforms."])
    yield from ("*STEP", "*STATIC, DIRECT", "1., 1.", "*BOUNDARY, OP=NEW")
    for name, body in bodies.items():
        if name in motions:
            yield from displacement_lines(body, slip * motions[name].at(body.mesh.points))
        else:
            yield f"{name}, 1, 3"
    for contact in contacts:
        yield f"*CONTACT PRINT, MASTER={contact.master}, SLAVE={contact.slave}"
        yield "CF"
    yield "*END STEP"


def _complex_step(
    contacts: list[DeckContact], bodies: Mapping[str, DeckBody], modes: int
) -> Iterator[str]:
    """Modes of small motions about it, with the supports of the scene."""
    yield from comments(["Modes about that state, with the supports and friction of the scene."])
    yield "*STEP, PERTURBATION"
    for contact in contacts:
        if contact.mu:
            yield keyword("CHANGE FRICTION", INTERACTION=contact.interaction)
            yield keyword("FRICTION")
            yield numbers([contact.mu, STICK * contact.stiffness])
    yield from ("*FREQUENCY, STORAGE=YES", str(modes))
    yield from boundary_lines(bodies, OP="NEW")
    yield from ("*NODE FILE", "U", "*END STEP")
