"""What a state of steady sliding must be read with.

Facets of a curved surface are tilted against it: an approach u of the sides that slides along the
true surface seems to close (n - n_true).u at a point, of either sign in a facet; projected on the
traces of a side most of it cancels. Of meshes from files the surface is not known: its distance
from the facets is estimated, and initial gaps below that count as zero.

Pressures crowd at the rim of a closed zone of width W, the more the stiffer the law is beside a
body: p W / E. Crowned blocks were pressed on blocks in the plane (841 scenes, each beside a mesh
five times finer). With n trace functions across the zone, the mean pressure that a unit of force
meets was off by

    n / (p W / E)^(1/3)     0.3 to 0.5   0.5 to 0.6   0.6 to 0.8   1 to 1.2   2 or more
    median, 90 % below      15, 41 %     13, 27 %     8, 16 %      2, 7 %     0.2, 2 %

Below 0.6 unstable modes were missed, above it none; in space errors along both directions add up.
With laws as stiff as p W / E = 1e7, 20 functions across left 1 % with mortar.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from cea.arrays import Floats
from cea.contact.contact import Contact, approach_along
from cea.contact.laws import NormalCompliance
from cea.errors import ResultWarning
from cea.ranks import agreed
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from cea.system.coupled import CoupledSystem
from cea.system.steady_equations import LEFT_OVER
from cea.system.steady_state import ContactState, SteadySliding
from scenes.spec.reading import Scene

_NOISE = 4.0
"""Closures, in parts of what rounding makes of displacements, that are neither open nor closed."""


def steady_warnings(
    scene: Scene, system: CoupledSystem, steady: SteadySliding
) -> Iterator[ResultWarning]:
    """What a state of steady sliding must be read with; collective."""
    if steady.uniqueness is not None:
        yield from steady.uniqueness.warnings()
    if steady.residual > LEFT_OVER:
        told = f"rounding leaves {steady.residual:.1e} of the load of steady sliding over"
        yield ResultWarning("equilibrium-rounding", told, {"residual": steady.residual})
    largest = max(-steady.displacement.min()[1], steady.displacement.max()[1])
    for contact in system.contacts:
        if contact.name in steady.contacts:
            state = steady.contacts[contact.name]
            yield from _undecided(contact, state, _NOISE * steady.uncertainty * largest)
            yield from _geometry_error(system, steady, contact, state)
            halves = sum(each.pair == contact.pair for each in system.contacts)
            yield from _coarse_closed_zone(scene, contact, state, halves)


def _undecided(contact: Contact, state: ContactState, noise: float) -> Iterator[ResultWarning]:
    """A contact that is open, or of which rounding decides where it is, as its stiffness jumps."""
    about, law = {"contact": contact.pair, "half": contact.name}, contact.law
    if not state.closed_area:
        told = f"contacts.{contact.name} is open in steady sliding: it carries nothing"
        yield ResultWarning("contact-open", told, about)
    points = np.abs(state.closure) <= noise
    fraction = float(contact.interface.points.weight[points].sum()) / state.area
    if fraction and isinstance(law, NormalCompliance) and law.m == 1:
        told = (
            f"rounding decides whether {fraction:.2g} of the area of contacts.{contact.name} is "
            "open; with m_n = 1 its stiffness jumps there"
        )
        yield ResultWarning("closure-undecided", told, about | {"fraction": fraction})


_ALLOWED = 0.01
"""Relative error of pressures in the mean square that is told; peaks err by two or three times it.

With rings that are shrunk into each other the estimate is right to a few per cent up to 0.1, at
degrees 1 to 3.
"""
_ROUNDED = 1e-9
"""Distance, relative to the mesh size, that is rounding of the numbers in a mesh file."""


def gaps_as_zero(contact: Contact) -> Iterator[ResultWarning]:
    """Initial gaps that are not above the error of the geometry of mesh files; collective."""
    interface = contact.interface
    with agreed(interface.comm):
        distance = np.abs(interface.true_distance)
        within = np.where(interface.initial_gap == 0, distance, 0.0)
        local = interface.local_points.weight[within > 0].sum(), within, interface.geometry_error
    areas, gaps, errors = zip(*interface.comm.allgather(local), strict=True)
    largest, error = (float(np.concatenate(parts).max(initial=0.0)) for parts in (gaps, errors))
    if largest > _ROUNDED * min(interface.a.mesh_size, interface.b.mesh_size):
        fraction = float(sum(areas) / interface.points.weight.sum())
        told = (
            f"initial gaps up to {largest:.2g} m, on {100 * fraction:.3g} % of the area of "
            f"contacts.{contact.name}, count as zero: its mesh has errors up to {error:.2g} m"
        )
        data = {
            "contact": contact.pair,
            "half": contact.name,
            "gap": largest,
            "geometry_error": error,
            "fraction": fraction,
        }
        yield ResultWarning("gaps-as-zero", told, data)


def _geometry_error(
    system: CoupledSystem, steady: SteadySliding, contact: Contact, state: ContactState
) -> Iterator[ResultWarning]:
    """Closures that do not stand out from the errors of curved facets; collective."""
    interface, law = contact.interface, contact.law
    assert isinstance(law, NormalCompliance)
    with agreed(interface.comm):
        tilt = interface.a.normal_error(interface.local_points.at)
        local = interface.geometry_error
    moved = {n: system.displacement(steady.displacement, n) for n in (contact.a, contact.b)}
    seeming = approach_along(contact, tilt, moved)
    error = np.concatenate(interface.comm.allgather(local)) + np.abs(contact.projected_gap(seeming))
    force = interface.points.weight * state.pressure
    if not force.any():
        return
    closure = float(force @ state.closure / force.sum())
    of_gaps = float(np.sqrt(force @ error**2 / force.sum()))
    relative = law.m * of_gaps / closure
    if relative > _ALLOWED:
        told = (
            f"curved facets leave {of_gaps:.2g} m of the closures of contacts.{contact.name} "
            f"undecided, {closure:.2g} m in the mean: pressures are off by {100 * relative:.2g} %"
        )
        data = {
            "contact": contact.pair,
            "half": contact.name,
            "closure": closure,
            "geometry_error": of_gaps,
            "relative": relative,
        }
        yield ResultWarning("geometry-error", told, data)


_FEWEST = {2: 0.6, 3: 1.0}
"""Trace functions across a closed zone that it needs, relative to (p W / E)^(1/3), by dimension."""
_ENOUGH = 20.0
"""Trace functions across that are enough however stiff the law is."""


class ClosedZone(NamedTuple):
    """The largest circle within the closed part of a contact; a stretch in the plane.

    It has its diameter (m), the unit vector from its centre to the nearest open point, and the
    closed points in it. A zone that ends at the rim of the contact, as at a plane of symmetry,
    counts as if it went on beyond it alike.
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
    """The closed zone of a contact; None where all of it is closed, or nothing."""
    closed, still_open = x[closure > 0], x[closure <= 0]
    if not len(closed) or not len(still_open):
        return None
    distance, nearest = KDTree(still_open).query(closed)
    inmost = int(distance.argmax())
    radius = float(distance[inmost])
    across = (still_open[nearest[inmost]] - closed[inmost]) / radius
    within = np.linalg.norm(closed - closed[inmost], axis=1) <= radius
    return ClosedZone(2 * radius, across, closed[within])


def _coarse_closed_zone(
    scene: Scene, contact: Contact, state: ContactState, halves: int
) -> Iterator[ResultWarning]:
    """A closed zone that ends inside a contact and has too few elements across for its law."""
    interface = contact.interface
    zone = closed_zone(interface.points.x, state.closure)
    if zone is None:
        return
    force = interface.points.weight * state.pressure
    stiffness = halves * float(force @ state.stiffness / force.sum())
    sides = []
    for name, surface in ((contact.a, interface.a), (contact.b, interface.b)):
        body = scene.bodies[name]
        relative = stiffness * zone.width / body.material.means[0]
        functions, iga = body.fe_degree, body.mesh.iga
        if body.backend == "iga" and iga is not None:
            functions = min(p - c for p, c in zip(iga.degree, iga.continuities, strict=True))
        needed = min(_FEWEST[surface.dim] * relative ** (1 / 3), _ENOUGH) / (functions or 1)
        sides.append((zone.elements(surface), needed, relative, f"{name}.{surface.name}"))
    elements, needed, relative, place = min(sides, key=lambda side: side[0] / side[1])
    if elements < needed:
        told = (
            f"the closed zone of contacts.{contact.name} is {elements:.2g} elements of {place} "
            f"wide; its law, p W / E = {relative:.2g}, needs {needed:.2g} for right pressures"
        )
        data = {
            "contact": contact.pair,
            "half": contact.name,
            "side": place,
            "width": zone.width,
            "elements": elements,
            "needed": needed,
            "stiffness": relative,
        }
        yield ResultWarning("coarse-closed-zone", told, data)
