"""Warnings about equilibria: states of steady sliding and static displacements.

The normals of facets differ from those of the curved surface. A relative displacement u of the
sides tangential to the true surface changes the gap by (n - n_true).u, of either sign in a facet;
most of it cancels in the projection on the traces of a side. For mesh files the true surface is
unknown: its distance from the facets is estimated, and smaller initial gaps count as zero.

Pressures concentrate at the edge of a closed zone of width W, more so for a large ratio p W / E of
the stiffness of the law to that of a body. Crowned blocks on blocks in the plane (841 scenes, each
compared with a mesh five times finer) with n trace functions across the zone had these errors of
the force-weighted mean pressure:

    n / (p W / E)^(1/3)     0.3 to 0.5   0.5 to 0.6   0.6 to 0.8   1 to 1.2   2 or more
    median, 90th percentile 15, 41 %     13, 27 %     8, 16 %      2, 7 %     0.2, 2 %

Below 0.6 unstable modes were missed, above 0.6 none. In three dimensions the errors along both
directions add up. At p W / E = 1e7 mortar with 20 functions across the zone had an error of 1 %.
"""

from functools import partial
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from cea.arrays import Floats
from cea.body import VolumeCells
from cea.contact.contact import Contact, approach_along, by_pair
from cea.contact.pressure_and_friction import NormalCompliance
from cea.ranks import agreed, made_on_first
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from cea.system.contact_stresses import normal_stress
from cea.system.coupled import CoupledSystem
from cea.system.steady_equations import LEFT_OVER
from cea.system.steady_state import ContactState, SteadySliding
from scenes.checking.warnings import Warnings, left_alone, warning
from scenes.spec.body import IgaMesh
from scenes.spec.reading import Scene

_STRAIN = 0.1
"""Principal strain above which a warning is given: the quadratic term e^2 / 2 of the Green-Lagrange
strain e + e^2 / 2 (Wriggers, Nonlinear Finite Element Methods, 2008) is then 5 % of e."""
_TENSILE = 0.01
"""Tension relative to the largest normal stress of a contact, and fraction of its area, above which
a warning is given."""
_NOISE = 4.0
"""Closure, relative to rounding errors of displacements, below which the status is undecided."""
_ALLOWED = 0.01
"""Estimated relative error of pressures (root mean square) above which a warning is given. Errors
of peaks are two to three times larger.

For shrink-fitted rings of degrees 1 to 3 the estimate is accurate to a few per cent up to 0.1.
"""
_FEWEST = {2: 0.6, 3: 1.0}
"""Least number of trace functions across a closed zone over (p W / E)^(1/3), by dimension."""
_ENOUGH = 20.0
"""Number of trace functions across a closed zone that suffices for any stiffness of the law."""


def tension_warnings(system: CoupledSystem, x: Any) -> Warnings:
    """Warn of linear contacts that carry tension because they cannot open; collective.

    Tension is the smaller of the normal stresses of both sides, since bending of a thin body on a
    coarse mesh disturbs that of its side.
    """
    told = "contacts.{contact} carries tension up to {tension:.3g} N/m^2 on {fraction:.2%} of its "
    told += "area: P and p hold the sides together, c_n lets them open"
    for name, (half, *_) in by_pair(system.contacts).items():
        if half.coupling == "bonded" or not half.law.linear:
            continue
        interface, bodies = half.interface, system.bodies
        u, v = system.displacement(x, half.a), system.displacement(x, half.b)
        with agreed(interface.comm):
            at_a, at_b = interface.local_points.at, interface.opposite.at
            of_a = normal_stress(interface.a, at_a, u, bodies[half.a].material)
            of_b = normal_stress(interface.b, at_b, v, bodies[half.b].material)
        stress = np.concatenate(interface.comm.allgather(np.minimum(of_a, of_b)))
        tensile = (stress > _TENSILE * np.abs(stress).max()) & (half.slope > 0)
        weight = interface.points.weight
        fraction = float(weight[tensile].sum() / weight.sum())
        if fraction > _TENSILE:
            tension = float(stress[tensile].max())
            yield warning("tension", told, contact=name, tension=tension, fraction=fraction)


def motion_warnings(scene: Scene, system: CoupledSystem, x: Any) -> Warnings:
    """Warn of displacements larger than the body and of strains too large for linear elasticity."""
    for name, body in system.bodies.items() if not left_alone(scene) else ():
        full = system.displacement(x, name)
        cells = body.space.volume_cells().straight()
        found = made_on_first(body.comm, partial(_motion, cells, full))
        motion, length, strain = body.comm.bcast(found)
        if motion > length:
            told = "bodies.{body} is displaced by {displacement:.3g} m, more than its length "
            told += "{length:.3g} m"
            about = {"displacement": motion, "length": length}
            yield warning("large-displacement", told, body=name, **about)
        if strain > _STRAIN:
            told = "bodies.{body} has strains up to {strain:.3g}, too large for linear elasticity"
            yield warning("large-strain", told, body=name, strain=strain)


def _motion(sample: VolumeCells, full: Floats) -> tuple[float, float, float]:
    """Return the largest displacement (m), length of the body (m) and largest mean cell strain."""
    u = sample.values @ full.reshape(-1, sample.points.shape[1])
    x, moved = sample.points[sample.cells], u[sample.cells]
    gradient = np.linalg.pinv(x - x.mean(axis=1, keepdims=True)) @ moved
    strains = np.linalg.eigvalsh(0.5 * (gradient + gradient.transpose(0, 2, 1)))
    lengths = np.ptp(sample.points, axis=0)
    motion = np.linalg.norm(u, axis=1).max()
    return float(motion), float(lengths.max()), float(np.abs(strains).max())


def steady_warnings(scene: Scene, system: CoupledSystem, steady: SteadySliding) -> Warnings:
    """Yield the warnings about a state of steady sliding; collective."""
    if steady.uniqueness is not None:
        yield from steady.uniqueness.warnings()
    if steady.residual > LEFT_OVER:
        told = "rounding errors leave a residual of {residual:.1e} of the load in steady sliding"
        yield warning("equilibrium-rounding", told, residual=steady.residual)
    largest = max(-steady.displacement.min()[1], steady.displacement.max()[1])
    for contact in system.contacts:
        if contact.name in steady.contacts:
            state = steady.contacts[contact.name]
            yield from _undecided(contact, state, _NOISE * steady.uncertainty * largest)
            if scene.stiffened_by_stress:
                yield from _fixed_direction(contact, state)
            yield from _geometry_error(system, steady, contact, state)
            halves = sum(each.pair == contact.pair for each in system.contacts)
            yield from _coarse_closed_zone(scene, contact, state, halves)
    yield from tension_warnings(system, steady.displacement)
    yield from motion_warnings(scene, system, steady.displacement)


def _undecided(contact: Contact, state: ContactState, noise: float) -> Warnings:
    """Warn of an open contact, and of a status that rounding decides for a linear law."""
    about, law = {"contact": contact.pair, "half": contact.name}, contact.law
    if not state.closed_area:
        told = "contacts.{half} is open everywhere in steady sliding"
        yield warning("contact-open", told, **about)
    points = np.abs(state.closure) <= noise
    fraction = float(contact.interface.points.weight[points].sum()) / state.area
    if fraction and isinstance(law, NormalCompliance) and law.m == 1:
        told = "rounding decides whether a fraction {fraction:.2g} of the area of contacts.{half} "
        told += "is open; with m_n = 1 the stiffness is discontinuous there"
        yield warning("closure-undecided", told, **about, fraction=fraction)


def _fixed_direction(contact: Contact, state: ContactState) -> Warnings:
    """Warn of contact pressures, which do not turn with the sides in the geometric stiffness."""
    largest = float(state.pressure.max(initial=0.0))
    if largest:
        told = "the geometric stiffness leaves out that the pressure of contacts.{half}, up to "
        told += "{pressure:.3g} N/m^2, turns with its sides"
        about = {"contact": contact.pair, "half": contact.name, "pressure": largest}
        yield warning("dead-contact-pressure", told, **about)


def _geometry_error(
    system: CoupledSystem, steady: SteadySliding, contact: Contact, state: ContactState
) -> Warnings:
    """Warn of closures comparable to the geometry errors of curved facets; collective."""
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
        told = "geometry errors of contacts.{half}, {geometry_error:.2g} m of a mean closure of "
        told += "{closure:.2g} m, change its pressures by {relative:.2%}"
        about = {"contact": contact.pair, "half": contact.name, "closure": closure}
        yield warning("geometry-error", told, **about, geometry_error=of_gaps, relative=relative)


def _closed_zone(x: Floats, closure: Floats) -> tuple[float, Floats, Floats] | None:
    """Return the largest circle inside the closed part of a contact; an interval in the plane.

    Returns its diameter (m), the unit vector from its centre to the nearest open point, and the
    closed points inside; None if all points are closed, or all open. A zone that ends at the
    boundary of the contact, e.g. at a plane of symmetry, is treated as if it continued
    symmetrically beyond it.
    """
    closed, still_open = x[closure > 0], x[closure <= 0]
    if not len(closed) or not len(still_open):
        return None
    distance, nearest = KDTree(still_open).query(closed)
    inmost = int(distance.argmax())
    radius = float(distance[inmost])
    across = (still_open[nearest[inmost]] - closed[inmost]) / radius
    within = np.linalg.norm(closed - closed[inmost], axis=1) <= radius
    return 2 * radius, across, closed[within]


def _mean_size(surface: Surface, points: Floats, across: Floats) -> float:
    """Return the mean extent (m) along a direction of the elements of a side at points."""
    cells = surface.cells
    count, corners = cells.corners.shape[:2]
    at = SurfaceCoordinates(
        np.repeat(cells.element, corners), cells.corners.reshape(count * corners, -1)
    )
    x = surface.position(at).reshape(count, corners, -1)
    _, nearest = KDTree(x.mean(axis=1)).query(points)
    return float(np.ptp(x @ across, axis=1)[nearest].mean())


def _coarse_closed_zone(
    scene: Scene, contact: Contact, state: ContactState, halves: int
) -> Warnings:
    """Warn of a closed zone inside a contact with too few elements across for its law."""
    interface = contact.interface
    zone = _closed_zone(interface.points.x, state.closure)
    if zone is None:
        return
    width, across, points = zone
    force = interface.points.weight * state.pressure
    stiffness = halves * float(force @ state.stiffness / force.sum())
    sides = []
    for name, surface in ((contact.a, interface.a), (contact.b, interface.b)):
        body = scene.bodies[name]
        relative = stiffness * width / body.material.means[0]
        functions, mesh = body.fe_degree, body.division
        if isinstance(mesh, IgaMesh):
            functions = min(p - c for p, c in zip(mesh.degree, mesh.continuities, strict=True))
        needed = min(_FEWEST[surface.dim] * relative ** (1 / 3), _ENOUGH) / (functions or 1)
        side: dict[str, Any] = {"side": f"{name}.{surface.name}", "width": width}
        side["elements"] = width / _mean_size(surface, points, across)
        sides.append(side | {"needed": needed, "stiffness": relative})
    worst = min(sides, key=lambda side: side["elements"] / side["needed"])
    if worst["elements"] < worst["needed"]:
        told = "the closed zone of contacts.{half} is {elements:.2g} elements of {side} wide; "
        told += "accurate pressures need {needed:.2g} at p W / E = {stiffness:.2g}"
        about = {"contact": contact.pair, "half": contact.name}
        yield warning("coarse-closed-zone", told, **about, **worst)
