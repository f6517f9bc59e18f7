"""Whether elements resolve a closed zone that ends inside its contact.

With the width W of the zone, the contact stiffness p there and Young's modulus E of a body, p W / E
says how much stiffer the law is than the body. The stiffer, the more trace functions the zone needs
across: pressures crowd at its rim, and a rim that lies inside an element makes them oscillate.

Crowned blocks were pressed on blocks in the plane (841 scenes: both backends, degrees 1 to 3,
mortar, segments and Gauss points, m_n from 1 to 2, p W / E from 1 to 2000, half to 40 elements
across, E of the other body up to a hundred times larger), each beside a mesh five times finer. With
n trace functions across, the mean pressure that a unit of force meets was off by

    n / (p W / E)^(1/3)     0.3 to 0.5   0.5 to 0.6   0.6 to 0.8   1 to 1.2   2 or more
    median, 90 % below      15, 41 %     13, 27 %     8, 16 %      2, 7 %     0.2, 2 %

Below 0.6 unstable modes were missed, above it none. In space errors along both directions add up:
at 0.6 it was off by 22 to 60 %, at 1 by 7 % (crowned boxes on boxes). With laws as
stiff as p W / E = 1e7, 20 functions across left 1 % with mortar, and 13 % where points lock (115
scenes in the plane).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from cea.arrays import Floats
from cea.contact.contact import Contact
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from cea.system.steady_state import ContactState
from cea.warned import ResultWarning
from scenes.spec.body import BodySpec

_FEWEST = {2: 0.6, 3: 1.0}
"""Trace functions across a closed zone that it needs, relative to (p W / E)^(1/3), by dimension."""
_ENOUGH = 20.0
"""Trace functions across that are enough however stiff the law is."""


@dataclass(frozen=True)
class ClosedZone:
    """The largest circle within the closed part of a contact; a stretch in the plane.

    Parameters
    ----------
    width
        Its diameter (m). A zone that ends at the rim of the contact, as at a plane of symmetry,
        counts as if it went on beyond it alike.
    across
        Unit vector from its centre to the nearest open point, shape (dim,).
    points
        Closed points in it (m), shape (n, dim).
    """

    width: float
    across: Floats
    points: Floats

    def elements(self, surface: Surface) -> float:
        """Elements of a side across it: knot spans, or facets."""
        cells = surface.cells()
        count, corners = cells.corners.shape[:2]
        at = SurfaceCoordinates(
            np.repeat(cells.element, corners), cells.corners.reshape(count * corners, -1)
        )
        x = surface.position(at).reshape(count, corners, -1)
        _, nearest = KDTree(x.mean(axis=1)).query(self.points)
        return self.width / float(np.ptp(x @ self.across, axis=1)[nearest].mean())


def closed_zone(x: Floats, closure: Floats) -> ClosedZone | None:
    """The closed zone of a contact; None where all of it is closed, or nothing.

    Parameters
    ----------
    x
        Its points (m), shape (n, dim).
    closure
        Closures there (m), shape (n,).
    """
    closed, still_open = x[closure > 0], x[closure <= 0]
    if not len(closed) or not len(still_open):
        return None
    distance, nearest = KDTree(still_open).query(closed)
    inmost = int(distance.argmax())
    radius = float(distance[inmost])
    across = (still_open[nearest[inmost]] - closed[inmost]) / radius
    within = np.linalg.norm(closed - closed[inmost], axis=1) <= radius
    return ClosedZone(2 * radius, across, closed[within])


def coarse_closed_zone(
    bodies: Mapping[str, BodySpec], contact: Contact, state: ContactState, halves: int
) -> Iterator[ResultWarning]:
    """A closed zone that ends inside a contact and has too few elements across for its law.

    Parameters
    ----------
    bodies
        Bodies of the scene.
    contact, state
        A half pass and what it carries.
    halves
        Half passes of the contact, each of which has its share of the stiffness.
    """
    interface, half = contact.interface, contact
    zone = closed_zone(interface.points.x, state.closure)
    if zone is None:
        return
    force = interface.points.weight * state.pressure
    stiffness = halves * float(force @ state.stiffness / force.sum())
    sides = []
    for name, surface in ((half.a, interface.a), (half.b, interface.b)):
        relative = stiffness * zone.width / bodies[name].material.E
        needed = min(_FEWEST[surface.dim] * relative ** (1 / 3), _ENOUGH) / _functions(bodies[name])
        sides.append((zone.elements(surface), needed, relative, f"{name}.{surface.name}"))
    elements, needed, relative, place = min(sides, key=lambda side: side[0] / side[1])
    if elements < needed:
        yield ResultWarning(
            "coarse-closed-zone",
            f"the closed zone of contacts.{contact.name} is {zone.width:.2g} m wide, "
            f"{elements:.2g} elements of {place}; with so stiff a law, p W / E = {relative:.2g}, "
            f"fewer than {needed:.2g} give no pressures or growth rates to rely on",
            {
                **{"contact": contact.pair, "half": contact.name, "side": place},
                **{"width": zone.width, "elements": elements, "needed": needed},
                "stiffness": relative,
            },
        )


def _functions(body: BodySpec) -> int:
    """Trace functions in an element along a direction, the fewest of any."""
    iga = body.mesh.iga
    if body.backend == "fe" and body.fe_degree is not None:
        return body.fe_degree
    assert iga is not None
    if iga.continuity is None:
        return 1
    return min(p - c for p, c in zip(iga.degree, iga.continuity, strict=True))
