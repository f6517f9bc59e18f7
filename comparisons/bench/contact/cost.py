"""What it costs to search and to assemble a contact, beside evaluating the bases at its points."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import process_time
from typing import Any

from cea.contact.contact import assembled
from cea.contact.interface import default_reach, pair
from cea.matrices import destroy
from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_contacts
from scenes.spec.reading import read_scene

GAUSS_POINTS = {"method": "gpts", "points": 4}
_FEWER = 0.9
"""Elements of the lower block along a side, relative to those of the upper: meshes do not match."""


@dataclass(frozen=True)
class ContactCost:
    """Processor time (s) of one contact, stage by stage.

    Parameters
    ----------
    points
        Number of its points.
    basis
        Values of the basis functions of both sides at the points, as sparse rows.
    rule
        Points and weights.
    search
        Points located on the other side, with the values there.
    assembly
        Gap and slip operators on the unknowns, and K_n and K_f or, where gaps are projected, the
        integrals and compliances that stand for them.
    """

    points: int
    basis: float
    rule: float
    search: float
    assembly: float


def contact_cost(
    backend: str, elements: int, formulation: Mapping[str, Any] = GAUSS_POINTS
) -> ContactCost:
    """Measure a block on a block with friction, of quadratic elements, in three dimensions.

    Parameters
    ----------
    backend
        ``fe`` or ``iga``.
    elements
        Elements along each side of the upper block.
    formulation
        Points of the contact, as in scenes.
    """
    scene = read_scene(_blocks(backend, elements, formulation))
    bodies = build_bodies(scene, StageTimer())
    a, b = bodies["upper"].surfaces["z_min"], bodies["lower"].surfaces["z_max"]
    for body in bodies.values():
        _ = body.expansion
    rule = scene.contacts["contact"].formulation
    points, of_rule = _timed(lambda: rule.points_on(a, b, default_reach(a, b)))
    interface, search = _timed(lambda: pair(a, b, points))
    at, opposite = interface.points.at, interface.opposite.at
    _, basis = _timed(lambda: (a.trace(at), b.trace(opposite)))
    (half,) = build_contacts(scene, {"contact": interface})
    contact, operators = _timed(lambda: assembled(bodies, half))
    if contact.projection is None:
        made, matrices = _timed(lambda: (contact.K_n, contact.K_f))
        destroy(*made)
    else:
        made, matrices = _timed(lambda: contact.compliance(contact.slope))
        destroy(made)
    return ContactCost(len(points), basis, of_rule, search, operators + matrices)


def _timed[T](work: Callable[[], T]) -> tuple[T, float]:
    """What some work makes, and the processor time it takes (s)."""
    start = process_time()
    made = work()
    return made, process_time() - start


def _blocks(backend: str, elements: int, formulation: Mapping[str, Any]) -> dict[str, Any]:
    """Scene of a block on a block, one element through the height of each."""

    def block(low: float, along: int) -> dict[str, Any]:
        counts = [along, along, 1]
        mesh = {
            "fe": {"degree": 2, "elements": counts},
            "iga": {"degree": [2, 2, 2], "elements": counts},
        }
        return {
            "backend": backend,
            "geometry": {"shape": "box", "size": [1.0, 1.0, 0.5], "origin": [0.0, 0.0, low]},
            "material": {"E": 1.0, "nu": 0.3, "rho": 1.0},
            "mesh": mesh,
        }

    return {
        "name": "contact of two blocks",
        "bodies": {
            "upper": block(0.0, elements),
            "lower": block(-0.5, max(1, round(_FEWER * elements))),
        },
        "contacts": {
            "contact": {
                "a": "upper.z_min",
                "b": "lower.z_max",
                "formulation": dict(formulation),
                "P": 1.0,
                "mu": 0.3,
                "friction_direction_on_a": {"vector": [1.0, 0.0, 0.0]},
            }
        },
        "analysis": {"kind": "cea", "max_frequency": 1.0},
    }
