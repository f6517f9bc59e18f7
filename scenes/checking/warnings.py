"""Warnings about bodies and contacts that are known before the solve.

Each kind of warning has a function in one of two lists. Warnings about waves are in
:mod:`scenes.checking.resolution`, about equilibria in :mod:`scenes.checking.equilibrium`, about
modes, their errors and the window in :mod:`cea.eigen.modes`.

Probable mistakes are reported too: numbers that are implausible in SI units, and overlapping
bodies. Numbers are not checked if units = "other", or if every E and rho is near one, as in
dimensionless scenes; the run then lists this check as skipped.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations
from math import inf
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from cea.arrays import Floats
from cea.body import Body, VolumeCells
from cea.contact.contact import Contact
from cea.contact.interface import nested, sampling
from cea.contact.pressure_and_friction import Circumferential
from cea.errors import ResultWarning
from cea.expressions import evaluate
from cea.motion import Rotation
from cea.ranks import agreed, made_on_first
from meshes.mesh_file import MeshFile
from scenes.building.build import used_surfaces
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

Bodies = Mapping[str, Body]
Warnings = Iterator[ResultWarning]

_SOFTEST = 1e3
"""Young's modulus (N/m^2) below which a material is implausible, softer than rubber."""
_HEAVIEST = 1e6
"""Density (kg/m^3) above which a material is implausible, fifty times that of platinum."""
_SOUND = (50.0, 20e3)
"""Plausible speeds of sound sqrt(E / rho) (m/s): 52 in soft rubber (E 3e6 N/m^2, rho 1,100 kg/m^3),
17,700 in diamond (1.1e12, 3,515)."""
_LENGTHS = (1e-5, 100.0)
"""Plausible length (m) of the longest side of a body, from micromachines to rails."""
_NEAR_ONE = (1e-3, 1e2)
"""Range of E and rho in which a scene is treated as dimensionless."""
_UNITS = "; set units = 'other' if the numbers are not in SI units"
_FLAT = 1e-12
"""Volume of a simplex, relative to its radius to the power dim, below which it is degenerate."""
_SIMPLICES = {
    (2, 3): [[0, 1, 2]],
    (2, 4): [[0, 2, 3], [0, 3, 1]],
    (3, 4): [[0, 1, 2, 3]],
    (3, 8): [[0, 7, i, j] for i, j in ((4, 6), (6, 2), (2, 3), (3, 1), (1, 5), (5, 4))],
}
"""Corners of the simplices of a cell, by dimension and number of points of the cell."""
_SLOW_ROTATION = 1e-2
"""Rate relative to omega of the window up to which rotation hardly changes damping by friction."""
_SURFACE_WAVES = 0.8
"""Speed, relative to shear waves, above which a rim may outrun surface waves: Rayleigh waves travel
at 0.87 (nu = 0) to 0.96 (nu = 0.5), short waves of a mesh slightly slower."""
_INCOMPRESSIBLE = {
    ("fe", 1): 0.45,
    ("fe", 2): 0.499,
    ("iga", 1): 0.45,
    ("iga", 2): 0.495,
    ("iga", 3): 0.4999,
}
"""Poisson's ratio, by backend and degree, above which volumetric locking is expected.

Above it the first three frequencies of a cantilever of length 4 and height 1, with four elements
over the height, have errors of 2 % or more, at least ten times those at nu = 0.3 (for degree 1,
with 3 % there, three times). Lagrange elements of degree 3 and splines of degree 4 do not lock.
"""
_UNCOVERED = 1e-3
"""Fraction of the area of side a without an opposite point above which a warning is given."""
_CLOSED = 1e-2
"""Distance of the sides, relative to the smaller mesh size, attributed to curved meshes."""
_NO_SLIP = 1e-9
"""Slip velocity, relative to the velocities of the sides, and cosine of a right angle, attributed
to rounding."""
_MISALIGNED = 20.0
"""Mean angle (degrees) between friction and slip above which a warning is given. A pad that spans
an angle of 80 degrees on a disc has this mean angle if its direction is uniform."""
_OPPOSED = 1e-2
"""Fraction of the area above which friction along the slip velocity is warned of."""
_ROUNDED = 1e-9
"""Distance, relative to the mesh size, attributed to rounding of the numbers in a mesh file."""
_LOCKS = 500.0
"""p h / E above which too many points cause locking: none at 55, errors of 20 % at 5500."""

_COLLOCATION: dict[tuple[str, int], float] = {
    ("equal", 2): 600.0,  # abscissae of NURBS: 2 % at 60, 0.02 % at 6000
    ("equal", 3): inf,
    ("area", 3): inf,  # 3 to 90 % from 0.1 to 1100; in the plane about 1 %
    ("nodes", 2): 30.0,  # nodes of equal weights: 10 % at 6, 0.9 % at 60
    ("nodes", 3): 30.0,
    ("grid", 2): 30.0,  # 9 % at 6, 0.5 % at 60
    ("grid", 3): 600.0,  # 5 % at 11, 0.7 % at 1100
}
"""Relative stiffness of a contact below which a collocation rule is too inaccurate, by rule and
dimension; comments give errors at relative stiffnesses."""
_LUMPED: dict[tuple[str, int], float] = {
    ("iga", 2): 0.0,  # 2 % at 0.6, 9 % at 6, 70 % at 60
    ("iga", 3): 0.0,
    ("fe", 2): 60.0,  # 0.5 % at 60, 11 % at 6000
    ("fe", 3): 3.0,  # 0.8 % at 1, modes lost at 11
}
"""Relative stiffness above which lumping is too inaccurate, by backend of side a and dimension.

The errors in both tables are those of growth rates in `uses.csv` of `cea study accuracy`. There, p
in the units of a problem is a relative stiffness of 6 in blocks and drum, and 1 in ring.
"""

_PROJECTED = ("mortar", "bonded")
"""Couplings that do not use gaps at points."""


def warning(kind: str, sentence: str, **data: Any) -> ResultWarning:
    """Return a warning with the data formatted into the sentence."""
    return ResultWarning(kind, sentence.format(**data), data)


def warnings_of(scene: Scene, bodies: Bodies, contacts: Sequence[Contact]) -> Warnings:
    """Yield the warnings about the bodies and contacts of a scene; collective."""
    for of_body in OF_BODIES:
        yield from of_body(scene, bodies)
    for name in scene.contacts:
        halves = [contact for contact in contacts if contact.pair == name]
        for of_contact in OF_CONTACTS if halves else ():
            yield from of_contact(scene, name, halves)


def left_alone(scene: Scene) -> str:
    """Return why the numbers of a scene are not in SI units; "" if they are assumed to be."""
    if scene.units == "other":
        return "units = 'other'"
    low, high = _NEAR_ONE
    materials = [body.material for body in scene.bodies.values()]
    numbers = [n for each in materials for n in (each.means[0], each.rho) if n is not None]
    near_one = all(low <= n <= high for n in numbers)
    return "every E and rho is near one, as in dimensionless scenes" if near_one else ""


def doubtful_numbers(scene: Scene, _bodies: Bodies | None = None) -> Warnings:
    """Warn of materials and sizes of bodies that are implausible in SI units."""
    doubt = "bodies.{body}.material.{field} = {value:g}: no solid has "
    for name, body in scene.bodies.items() if not left_alone(scene) else ():
        E, rho = body.material.means[0], body.material.rho
        speed, (slow, fast), (low, high) = float(np.sqrt(E / (rho or inf))), _SOUND, _LENGTHS
        doubts = []
        if E < _SOFTEST:
            doubts.append(("E", E, f"E below {_SOFTEST:g} N/m^2"))
        if rho is not None and rho > _HEAVIEST:
            doubts.append(("rho", rho, f"rho over {_HEAVIEST:g} kg/m^3"))
        if rho is not None and not doubts and not slow <= speed <= fast:
            bound = f"a speed of sound below {slow:g} or over {fast:g} m/s"
            doubts.append(("sqrt(E/rho)", speed, bound))
        for field, value, bound in doubts:
            told = f"{doubt}{bound}{_UNITS}"
            yield warning("doubtful-units", told, body=name, field=field, value=value)
        length = max(body.lengths)
        if not low <= length <= high:
            told = f"bodies.{{body}} is {{length:.3g}} m long, expected {low:g} to {high:g}{_UNITS}"
            yield warning("doubtful-size", told, body=name, length=length)


def _overlapping(scene: Scene, bodies: Bodies) -> Warnings:
    """Warn of overlapping bodies without a contact; collective."""
    joined = [{body for body, _ in contact.sides} for contact in scene.contacts.values()]
    pairs = [pair for pair in combinations(bodies, 2) if set(pair) not in joined]
    names = dict.fromkeys(name for pair in pairs for name in pair)  # in one order on all ranks
    samples = {name: bodies[name].space.volume_cells().straight() for name in names}
    for one, other in pairs:
        counted = partial(_overlap, samples[one], samples[other])
        cells = bodies[one].comm.bcast(made_on_first(bodies[one].comm, counted))
        if cells:
            told = "bodies.{body} and bodies.{other} overlap by {elements} elements, and no "
            told += "contact joins them"
            yield warning("bodies-overlap", told, body=one, other=other, elements=cells)


def _overlap(one: VolumeCells, other: VolumeCells) -> int:
    """Count the cells of either body whose midpoint is inside the other."""
    return _inside(one, other) + _inside(other, one)


def _inside(one: VolumeCells, other: VolumeCells) -> int:
    """Count the cells of ``one`` whose midpoint is inside a straight cell of ``other``."""
    middles = one.points[one.cells].mean(axis=1)
    dim = middles.shape[1]
    simplices = other.cells[:, _SIMPLICES[dim, other.cells.shape[1]]].reshape(-1, dim + 1)
    corners = other.points[simplices]
    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    edges = (corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    solid = np.abs(np.linalg.det(edges)) > _FLAT * radii**dim
    near = KDTree(middles).query_ball_point(centres[solid], radii[solid])
    point = np.array([i for some in near for i in some], dtype=np.int64)
    simplex = np.flatnonzero(solid).repeat([len(some) for some in near])
    away = (middles[point] - corners[simplex, 0])[:, :, None]
    parts = np.linalg.solve(edges[simplex], away)[:, :, 0]
    within = (parts > 0).all(axis=1) & (parts.sum(axis=1) < 1)
    return len(np.unique(point[within]))


def _volumetric_locking(scene: Scene, _bodies: Bodies) -> Warnings:
    """Warn of nearly incompressible materials in elements of too low a degree."""
    told = "bodies.{body} is nearly incompressible (nu = {nu:g}); elements of degree {degree} show "
    told += "volumetric locking from nu = {limit:g}"
    for name, body in scene.bodies.items():
        kind, degree, nu = "iga" if body.smooth else "fe", body.degree, body.material.means[2]
        limit = _INCOMPRESSIBLE.get((kind, degree), inf)
        if nu >= limit:
            about = {"body": name, "nu": nu, "degree": degree, "limit": limit}
            yield warning("volumetric-locking", told, **about)


def _nodes_left_out(scene: Scene, _bodies: Bodies) -> Warnings:
    """Warn of node sets with nodes that do not belong to a face of the set."""
    told = "{nodes} nodes of {body}.{surface} do not belong to a face of the set and are left out"
    for body, spec in scene.bodies.items():
        if isinstance(spec.geometry, MeshFile):
            counts = spec.geometry.nodes_left_out(used_surfaces(scene, body))
            for surface, count in counts.items():
                yield warning("nodes-left-out", told, body=body, surface=surface, nodes=count)


def _centrifugal_stresses(scene: Scene, _bodies: Bodies) -> Warnings:
    """Warn of convective stiffness without the geometric stiffness of centrifugal stresses."""
    told = "bodies.{body} has the convective stiffness of its rotation without the geometric "
    told += "stiffness of its centrifugal stresses: lambda is uncertain by (rate / |lambda|)^2"
    for name, body in scene.bodies.items() if scene.analysis.kind == "cea" else ():
        rotation = body.rotation
        if rotation is not None and rotation.convective_stiffness and rotation.coriolis:
            yield warning("centrifugal-stresses", told, body=name, rate=rotation.rate)


def _friction_damping(scene: Scene, _bodies: Bodies) -> Warnings:
    """Warn of damping by sliding on a body that rotates fast: its circulatory part is left out."""
    told = (
        "contacts.{contact} has damping by sliding on bodies.{body}, which rotates: about m rate "
    )
    told += "/ |lambda| of it, with m nodal diameters, acts on displacements and is left out"
    analysis = scene.analysis
    end = 2 * np.pi * analysis.max_frequency if analysis.kind == "cea" else inf
    for name, contact in scene.contacts.items():
        for body, _ in contact.sides if contact.sliding is not None else ():
            rotation = scene.bodies[body].rotation
            if rotation is not None and rotation.rate > _SLOW_ROTATION * end:
                yield warning("friction-damping", told, contact=name, body=body, rate=rotation.rate)


def _faster_than_waves(scene: Scene, bodies: Bodies) -> Warnings:
    """Warn of bodies with convective stiffness that may be faster than surface waves; collective.

    Above that speed, K - Omega^2 Z of a mesh has short waves of negative energy. Rounding and
    unresolved waves make them grow, although the exact body is stable.
    """
    told = "bodies.{body} moves at up to {speed:.3g} m/s, close to or above the speed of its "
    told += "surface waves (shear waves {wave_speed:.3g} m/s): short waves of its mesh may grow"
    for name, body in bodies.items():
        rotation = scene.bodies[name].rotation
        if rotation is None or not rotation.convective_stiffness or body.material.rho is None:
            continue
        velocities = _velocity(rotation, body.space.volume_cells().straight().points)
        fastest = np.linalg.norm(velocities, axis=1).max(initial=0.0)
        speed = float(max(body.comm.allgather(fastest)))
        wave = float(np.sqrt(body.material.means[1] / body.material.rho))
        if speed > _SURFACE_WAVES * wave:
            yield warning("faster-than-waves", told, body=name, speed=speed, wave_speed=wave)


def _velocity(rotation: Rotation | None, x: Floats) -> Floats:
    if rotation is None:
        return np.zeros_like(x)
    return rotation.rate * Circumferential(rotation.axis, rotation.origin).at(x)


OF_BODIES: list[Callable[[Scene, Bodies], Warnings]] = [
    doubtful_numbers,
    _overlapping,
    _volumetric_locking,
    _nodes_left_out,
    _centrifugal_stresses,
    _friction_damping,
    _faster_than_waves,
]
"""Functions that yield the warnings about bodies; collective."""


def _against_rotation(scene: Scene, name: str, halves: Sequence[Contact]) -> Warnings:
    """Warn of friction on side a that is not opposite to its velocity relative to side b."""
    spec, half = scene.contacts[name], halves[0]
    slides = spec.mu != 0 or spec.sliding is not None
    if half.friction is None or not slides or scene.analysis.kind != "cea":
        return
    points = half.interface.points
    on_a, on_b = (_velocity(scene.bodies[body].rotation, points.x) for body in (half.a, half.b))
    slip, size = on_a - on_b, np.abs(on_a).max() + np.abs(on_b).max()
    speed = np.linalg.norm(slip, axis=1)
    moving = speed > _NO_SLIP * size
    if not moving.any():
        return
    k, area = half.friction.along(points.x, points.normal)[moving], points.weight[moving]
    cosine = np.clip(-(slip[moving] * k).sum(axis=1) / speed[moving], -1.0, 1.0)
    angle = float(np.degrees(area @ np.arccos(cosine)) / area.sum())
    fraction = float(area[cosine < -_NO_SLIP].sum() / area.sum())
    if angle > _MISALIGNED or fraction > _OPPOSED:
        told = "friction_direction_on_a of contacts.{contact} is {angle:.3g} degrees on average "
        told += "off the direction that the rotations give, and along the velocity of side a "
        told += "relative to side b on {fraction:.2%} of the area; friction acts against that "
        told += "velocity"
        mean = -float(area @ (cosine * speed[moving])) / float(points.weight.sum())
        about = {"angle": angle, "fraction": fraction, "mean_velocity": mean}
        yield warning("against-rotation", told, contact=name, **about)


def _gap_closed(scene: Scene, name: str, halves: Sequence[Contact]) -> Warnings:
    """Warn of sides that are apart or overlap and are treated as touching."""
    interfaces = [contact.interface for contact in halves]
    farthest = max(interface.largest_distance for interface in interfaces)
    size = min(min(i.a.mesh_size, i.b.mesh_size) for i in interfaces)
    if scene.contacts[name].c_n is None and farthest > _CLOSED * size:
        told = "the sides of contacts.{contact} are up to {distance:.3g} m apart, or inside each "
        told += "other by as much, and are treated as touching"
        yield warning("gap-closed", told, contact=name, distance=farthest, mesh_size=size)


def _gaps_as_zero(scene: Scene, name: str, halves: Sequence[Contact]) -> Warnings:
    """Warn of initial gaps below the geometry error of mesh files; collective."""
    told = "initial gaps up to {gap:.2g} m, on {fraction:.3g} of the area of contacts.{half}, "
    told += "count as zero: its mesh has errors up to {geometry_error:.2g} m"
    for half in halves if scene.contacts[name].c_n is not None else ():
        interface = half.interface
        with agreed(interface.comm):
            distance = np.abs(interface.true_distance)
            within = np.where(interface.initial_gap == 0, distance, 0.0)
            area = interface.local_points.weight[within > 0].sum()
            local = area, within.max(initial=0.0), interface.geometry_error.max(initial=0.0)
        areas, gaps, errors = zip(*interface.comm.allgather(local), strict=True)
        if max(gaps) > _ROUNDED * min(interface.a.mesh_size, interface.b.mesh_size):
            about = {"contact": name, "half": half.name, "gap": float(max(gaps))}
            about["geometry_error"] = float(max(errors))
            about["fraction"] = float(sum(areas) / interface.points.weight.sum())
            yield warning("gaps-as-zero", told, **about)


def _partly_uncovered(scene: Scene, name: str, halves: Sequence[Contact]) -> Warnings:
    """Warn of a part of side a without opposite points; in a full pass, of the smaller side."""
    interface = halves[0].interface
    if scene.contacts[name].full_pass:
        interface = min((c.interface for c in halves), key=lambda each: each.a.area)
    fraction = 1 - float(interface.points.weight.sum()) / interface.a.area
    if fraction > _UNCOVERED:
        told = "{fraction:.2%} of {side} in contacts.{contact} has no opposite point"
        side = interface.a.name
        yield warning("partly-uncovered", told, contact=name, fraction=fraction, side=side)


def _sampled(scene: Scene, name: str, halves: Sequence[Contact]) -> Warnings:
    """Warn of too few points for the traces of a side, or of locking by too many points."""
    half, spec = halves[0], scene.contacts[name]
    if spec.formulation.coupling in _PROJECTED:
        return
    counts = [sampling(contact.interface) for contact in halves]
    functions = {
        half.a: max([counts[0].functions_a, *(c.functions_b for c in counts[1:])]),
        half.b: max([counts[0].functions_b, *(c.functions_a for c in counts[1:])]),
    }
    points, most = sum(count.points for count in counts), max(functions.values())
    about = {"contact": name, "points": points, "functions": functions}
    if points < most:
        told = "{points} points of contacts.{contact} are fewer than the trace functions of its "
        told += "sides, by body {functions}: some gaps have no stiffness"
        yield warning("under-sampled", told, **about)
    if half.awaits_state:
        return
    # P h / E with the mesh size h and E of the side for which h / E is larger
    sides = ((half.a, half.interface.a), (half.b, half.interface.b))
    yields = (s.mesh_size / scene.bodies[body].material.means[0] for body, s in sides)
    stiffness = _mean_stiffness(spec, halves) * max(yields)
    if points > most and stiffness > _LOCKS and not nested(half.interface):
        told = "{points} points of contacts.{contact} over-constrain its trace functions, by body "
        told += "{functions}, which locks; mortar does not"
        yield warning("over-constrained", told, **about, stiffness=stiffness)


def _point_rule(scene: Scene, name: str, halves: Sequence[Contact]) -> Warnings:
    """Warn of a point rule that is too inaccurate at the stiffness of the contact."""
    half, spec = halves[0], scene.contacts[name]
    coupling, of_modes = spec.formulation.coupling, scene.analysis.kind == "cea"
    if coupling in _PROJECTED or half.awaits_state or not spec.mu or not of_modes:
        return
    stiffness, limit = _relative_stiffness(scene, spec, halves), _limit_of(scene, spec)
    if (stiffness > limit) if coupling == "lumped" else (stiffness < limit):
        fine = "below" if coupling == "lumped" else "above"
        told = "{rule} in contacts.{contact} is too inaccurate for growth rates at "
        if 0 < limit < inf:
            told += f"p L / E = {{stiffness:.2g}}: it is not {fine} {{limit:g}}"
        else:
            told += "any stiffness, here p L / E = {stiffness:.2g}"
        about = {"contact": name, "rule": spec.formulation.label}
        yield warning("point-rule", told, **about, stiffness=stiffness, limit=limit)


def _limit_of(scene: Scene, spec: ContactSpec) -> float:
    """Return the relative stiffness below which collocation, or above which lumping, is poor."""
    side, rule = scene.bodies[spec.sides[0][0]], spec.formulation
    if rule.coupling == "lumped":
        return _LUMPED[side.backend, side.dim]
    weights = getattr(rule, "weights", "")
    of_nodes = {"node_to_surface/equal": "nodes", "grid/": "grid"}
    abscissae = weights if rule.method in ("greville", "botella") else ""
    kind = of_nodes.get(f"{rule.method}/{weights}", abscissae)
    return _COLLOCATION.get((kind, side.dim), 0.0)


def _relative_stiffness(scene: Scene, spec: ContactSpec, halves: Sequence[Contact]) -> float:
    """Return p (L_a / E_a + L_b / E_b), the ratio of contact stiffness to that of the bodies.

    L is the smaller of the least length of a body and the width of the contact; p is the mean
    contact stiffness (N/m^3).
    """
    half, compliance = halves[0], 0.0
    width = float(half.interface.points.weight.sum()) ** (1 / (half.interface.a.dim - 1))
    for name in (half.a, half.b):
        body = scene.bodies[name]
        compliance += min(*body.lengths, width) / body.material.means[0]
    return _mean_stiffness(spec, halves) * compliance


def _mean_stiffness(spec: ContactSpec, halves: Sequence[Contact]) -> float:
    """Return the mean contact stiffness p (N/m^3), open parts included; with c_n, while sliding.

    ``halves`` may have been assembled at another stiffness than that of ``spec``.
    """
    points = halves[0].interface.points
    area = float(points.weight.sum())
    if spec.c_n is not None:
        return sum(half.P for half in halves) / area
    if isinstance(spec.p, str):
        return float(points.weight @ evaluate(spec.p, points.x)) / area
    return spec.p if spec.p is not None else (spec.P or 0.0) / area


OF_CONTACTS: list[Callable[[Scene, str, Sequence[Contact]], Warnings]] = [
    _against_rotation,
    _gap_closed,
    _gaps_as_zero,
    _partly_uncovered,
    _sampled,
    _point_rule,
]
"""Functions that yield the warnings about a contact from its name and half passes; collective."""
