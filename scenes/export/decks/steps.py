"""The steps of a deck: steady sliding, then frequencies about it.

CalculiX does not compute that state itself. It is imposed by a static step with all nodes fixed, so
that all contacts keep the given overlap and nothing deforms; the frequency step then releases all
nodes except the supports.

The static step displaces the moving bodies as rigid bodies, far enough for every point to slip.
Friction then equals the limit up to rounding, and the frequency step would treat many points as
sticking: for the disc and pad it then finds no instability. The static step therefore has twice the
friction; with that of the scene all points are then beyond the limit. Normal to the slip direction
CalculiX adds the stick stiffness, which the scene does not have; it is chosen small.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from scenes.export.decks.bodies import DeckBody
from scenes.export.decks.contacts import MORE_FRICTION, STICK, DeckContact, RigidMotion
from scenes.export.decks.model import boundary_lines, comments, keyword, numbers, table

_BEYOND = 2.0
"""Imposed slip, relative to that at which a point begins to slip."""


def step_lines(
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
        slip = _BEYOND * MORE_FRICTION * largest / STICK
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
            yield from ("*FRICTION", numbers(each.mu, STICK * each.stiffness))
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
