"""What equilibria must be read with: states of steady sliding, and static displacements.

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
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import KDTree

from cea.arrays import Floats
from cea.body.space import StraightCells
from cea.contact.contact import Contact, approach_along
from cea.contact.laws import NormalCompliance
from cea.errors import ResultWarning
from cea.ranks import agreed, made_on_first
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from cea.system.coupled import CoupledSystem
from cea.system.steady_equations import LEFT_OVER
from cea.system.steady_state import ContactState, SteadySliding
from scenes.checking.warnings import left_alone, warning
from scenes.spec.mesh import IgaMesh
from scenes.spec.reading import Scene

Warnings = Iterator[ResultWarning]

_STRAIN = 0.1
"""Strain of which the quadratic terms that linear elasticity leaves out, e^2 / 2 of the
Green-Lagrange strain e + e^2 / 2 (Wriggers, Nonlinear Finite Element Methods, 2008), are 5 %."""
_NOISE = 4.0
"""Closures, in parts of what rounding makes of displacements, that are neither open nor closed."""
_ALLOWED = 0.01
"""Relative error of pressures in the mean square that is told; peaks err by two or three times it.

With rings that are shrunk into each other the estimate is right to a few per cent up to 0.1, at
degrees 1 to 3.
"""
_FEWEST = {2: 0.6, 3: 1.0}
"""Trace functions across a closed zone that it needs, relative to (p W / E)^(1/3), by dimension."""
_ENOUGH = 20.0
"""Trace functions across that are enough however stiff the law is."""


def motion_warnings(scene: Scene, system: CoupledSystem, x: Any) -> Warnings:
    """Displacements larger than their body and strains that linear elasticity has no right to."""
    for name, body in system.bodies.items() if not left_alone(scene) else ():
        full = system.displacement(x, name, everywhere=False)
        cells = body.space.volume_cells().straight()
        found = made_on_first(body.comm, partial(_motion, cells, full))
        motion, length, strain = body.comm.bcast(found)
        if motion > length:
            told = "bodies.{body} is displaced by {displacement:.3g} m, more than its length "
            told += "{length:.3g} m"
            about = {"displacement": motion, "length": length}
            yield warning("large-displacement", told, body=name, **about)
        if strain > _STRAIN:
            told = "bodies.{body} is strained by up to {strain:.3g}: only small strains are right"
            yield warning("large-strain", told, body=name, strain=strain)


def _motion(sample: StraightCells, full: Floats) -> tuple[float, float, float]:
    """Largest displacement (m), length of the body (m), largest mean principal strain of a cell."""
    u = sample.values @ full.reshape(-1, sample.points.shape[1])
    x, moved = sample.points[sample.cells], u[sample.cells]
    gradient = np.linalg.pinv(x - x.mean(axis=1, keepdims=True)) @ moved
    strains = np.linalg.eigvalsh(0.5 * (gradient + gradient.transpose(0, 2, 1)))
    lengths = np.ptp(sample.points, axis=0)
    motion = np.linalg.norm(u, axis=1).max()
    return float(motion), float(lengths.max()), float(np.abs(strains).max())


def steady_warnings(scene: Scene, system: CoupledSystem, steady: SteadySliding) -> Warnings:
    """What a state of steady sliding must be read with; collective."""
    if steady.uniqueness is not None:
        yield from steady.uniqueness.warnings()
    if steady.residual > LEFT_OVER:
        told = "rounding leaves {residual:.1e} of the load of steady sliding over"
        yield warning("equilibrium-rounding", told, residual=steady.residual)
    largest = max(-steady.displacement.min()[1], steady.displacement.max()[1])
    for contact in system.contacts:
        if contact.name in steady.contacts:
            state = steady.contacts[contact.name]
            yield from _undecided(contact, state, _NOISE * steady.uncertainty * largest)
            yield from _geometry_error(system, steady, contact, state)
            halves = sum(each.pair == contact.pair for each in system.contacts)
            yield from _coarse_closed_zone(scene, contact, state, halves)
    yield from motion_warnings(scene, system, steady.displacement)


def _undecided(contact: Contact, state: ContactState, noise: float) -> Warnings:
    """A contact that is open, or of which rounding decides where it is, as its stiffness jumps."""
    about, law = {"contact": contact.pair, "half": contact.name}, contact.law
    if not state.closed_area:
        told = "contacts.{half} is open in steady sliding: it carries nothing"
        yield warning("contact-open", told, **about)
    points = np.abs(state.closure) <= noise
    fraction = float(contact.interface.points.weight[points].sum()) / state.area
    if fraction and isinstance(law, NormalCompliance) and law.m == 1:
        told = "rounding decides whether {fraction:.2g} of the area of contacts.{half} is open; "
        told += "with m_n = 1 its stiffness jumps there"
        yield warning("closure-undecided", told, **about, fraction=fraction)


def _geometry_error(
    system: CoupledSystem, steady: SteadySliding, contact: Contact, state: ContactState
) -> Warnings:
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
        told = "curved facets leave {geometry_error:.2g} m of the closures of contacts.{half} "
        told += "undecided, {closure:.2g} m in the mean: pressures are off by {relative:.2%}"
        about = {"contact": contact.pair, "half": contact.name, "closure": closure}
        yield warning("geometry-error", told, **about, geometry_error=of_gaps, relative=relative)


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
) -> Warnings:
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
        functions, mesh = body.fe_degree, body.division
        if isinstance(mesh, IgaMesh):
            functions = min(p - c for p, c in zip(mesh.degree, mesh.continuities, strict=True))
        needed = min(_FEWEST[surface.dim] * relative ** (1 / 3), _ENOUGH) / (functions or 1)
        side: dict[str, Any] = {"side": f"{name}.{surface.name}", "width": zone.width}
        side["elements"] = zone.elements(surface)
        sides.append(side | {"needed": needed, "stiffness": relative})
    worst = min(sides, key=lambda side: side["elements"] / side["needed"])
    if worst["elements"] < worst["needed"]:
        told = "the closed zone of contacts.{half} is {elements:.2g} elements of {side} wide; its "
        told += "law, p W / E = {stiffness:.2g}, needs {needed:.2g} for right pressures"
        about = {"contact": contact.pair, "half": contact.name}
        yield warning("coarse-closed-zone", told, **about, **worst)
