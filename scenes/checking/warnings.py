"""What the result of a scene must be read with, found in the scene, its contacts and its modes.

A function for each kind of warning. Those of the modes themselves, of their errors and of the
window, come from :mod:`cea.eigen.modes`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from math import factorial, inf, pi

import numpy as np
from numpy.typing import NDArray
from scipy.special import bernoulli

from cea.arrays import Complexes, Floats
from cea.body import Body
from cea.contact.contact import Contact
from cea.contact.sampling import nested, sampling
from cea.errors import ResultWarning
from cea.expressions import Expression, evaluate
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from meshes.mesh_file import MeshFile
from meshes.shapes import Shape, VentilatedDisc
from scenes.building.build import used_surfaces
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

_UNCOVERED = 1e-3
"""Part of side a that quadrature may lose."""
_CLOSED = 1e-2
"""Distance of the sides, relative to the smaller mesh size, that curved meshes may leave."""
_LOCKS = 500.0
"""p h / E from which too many points lock: at 55 they did not, at 5500 errors were 20 %."""
_SHORT = 0.02
"""Relative error of frequency from which a mode is too short for its mesh."""
_STILL = 0.1
"""Amplitude of a side, relative to that of the other, below which its waves do not count."""
_NYQUIST = 0.8
"""Part of the shortest wave that has a function for each half up to which a wave is one at all."""

Shapes = Callable[[SurfaceCoordinates], Complexes]
"""Displacements of all modes at points of a surface, shape (n, dim, modes)."""

_INCOMPRESSIBLE = {
    ("fe", 1): 0.45,
    ("fe", 2): 0.499,
    ("iga", 1): 0.45,
    ("iga", 2): 0.495,
    ("iga", 3): 0.4999,
}
"""Poisson's ratio by backend and degree from which volumetric locking is to be expected.

From there on a cantilever of length 4 and height 1, with four elements through its height, has
errors of 2 % or more in its first three frequencies, and ten times those at nu = 0.3; of degree 1,
where these are 3 %, three times. Lagrange elements of degree 3, and splines of degree 4, have not.
"""

_COLLOCATION: dict[tuple[str, int], float] = {
    ("equal", 2): 600.0,  # abscissae of NURBS: 2 % at 60, 0.02 % at 6000
    ("equal", 3): inf,
    ("area", 3): inf,  # 3 to 90 % from 0.1 to 1100; in the plane about 1 %
    ("nodes", 2): 30.0,  # nodes of equal weights: 10 % at 6, 0.9 % at 60
    ("nodes", 3): 30.0,
    ("grid", 2): 30.0,  # 9 % at 6, 0.5 % at 60
    ("grid", 3): 600.0,  # 5 % at 11, 0.7 % at 1100
}
"""Relative stiffness of a contact below which points of a rule are too crude, by dimension."""
_LUMPED: dict[tuple[str, int], float] = {
    ("iga", 2): 0.0,  # 2 % at 0.6, 9 % at 6, 70 % at 60
    ("iga", 3): 0.0,
    ("fe", 2): 60.0,  # 0.5 % at 60, 11 % at 6000
    ("fe", 3): 3.0,  # 0.8 % at 1, modes lost at 11
}
"""The same above which lumping is too crude, by backend of side a and dimension.

Both are errors of growth rates in `uses.csv` of `cea study accuracy`, where p in units of each
problem is a relative stiffness of 6 in blocks and drum, of 1 in ring.
"""


def scene_warnings(scene: Scene, contacts: Sequence[Contact]) -> tuple[ResultWarning, ...]:
    """Warnings of bodies and contacts, before anything is solved; collective."""
    found = [*_volumetric_locking(scene), *_nodes_left_out(scene)]
    if scene.analysis.kind == "cea" and scene.rotates:
        from scenes.checking.rotation import rotation_warnings

        found += rotation_warnings(scene, contacts)
    for name, spec in scene.contacts.items():
        halves = [contact for contact in contacts if contact.pair == name]
        if spec.c_n is None:
            found += _gap_closed(name, halves)
        else:
            from scenes.checking.steady import gaps_as_zero

            found += [warning for contact in halves for warning in gaps_as_zero(contact)]
        found += _partly_uncovered(name, spec, halves)
        if halves[0].coupling not in ("mortar", "bonded"):
            found += _sampled(name, scene, halves)
            if scene.analysis.kind == "cea" and spec.mu:
                found += point_rule(name, scene, halves)
    return tuple(found)


def _nodes_left_out(scene: Scene) -> Iterator[ResultWarning]:
    """Sets of nodes that hold more of a body than the faces that they are used for."""
    for body, spec in scene.bodies.items():
        if isinstance(spec.geometry, MeshFile):
            counts = spec.geometry.nodes_left_out(used_surfaces(scene, body))
            for surface, count in counts.items():
                told = f"{count} nodes of {body}.{surface} make no face of the set and are left out"
                data = {"body": body, "surface": surface, "nodes": count}
                yield ResultWarning("nodes-left-out", told, data)


def _volumetric_locking(scene: Scene) -> Iterator[ResultWarning]:
    """Materials that keep their volume, in elements of a degree too low for them."""
    for name, body in scene.bodies.items():
        degree, smooth = _degree(body)
        limit = _INCOMPRESSIBLE.get(("iga" if smooth else "fe", degree), inf)
        nu = body.material.means[2]
        if nu >= limit:
            told = (
                f"bodies.{name} is nearly incompressible (nu = {nu:g}); elements of "
                f"degree {degree} are too stiff from nu = {limit:g} on"
            )
            data = {"body": name, "nu": nu, "degree": degree, "limit": limit}
            yield ResultWarning("volumetric-locking", told, data)


def _gap_closed(name: str, halves: Sequence[Contact]) -> Iterator[ResultWarning]:
    """Sides that do not touch and are taken to be in contact."""
    interfaces = [contact.interface for contact in halves]
    farthest = max(interface.largest_distance for interface in interfaces)
    size = min(min(i.a.mesh_size, i.b.mesh_size) for i in interfaces)
    if farthest > _CLOSED * size:
        told = (
            f"the sides of contacts.{name} are up to {farthest:.3g} m apart, or as far inside each "
            "other, and are taken to touch"
        )
        data = {"contact": name, "distance": farthest, "mesh_size": size}
        yield ResultWarning("gap-closed", told, data)


def _partly_uncovered(
    name: str, spec: ContactSpec, halves: Sequence[Contact]
) -> Iterator[ResultWarning]:
    """A part of side a that found nothing; the larger side of a full pass is meant to."""
    interface = halves[0].interface
    if spec.full_pass:
        interface = min((c.interface for c in halves), key=lambda each: each.a.area)
    fraction = 1 - float(interface.points.weight.sum()) / interface.a.area
    if fraction > _UNCOVERED:
        told = f"{100 * fraction:.2g} % of {interface.a.name} in contacts.{name} find no other side"
        yield ResultWarning("partly-uncovered", told, {"contact": name, "fraction": fraction})


def _sampled(name: str, scene: Scene, halves: Sequence[Contact]) -> Iterator[ResultWarning]:
    """Points too few for the traces of a side; or too many, at a stiffness at which they lock."""
    counts = [sampling(contact.interface) for contact in halves]
    points = sum(count.points for count in counts)
    functions = {
        halves[0].a: max([counts[0].functions_a, *(c.functions_b for c in counts[1:])]),
        halves[0].b: max([counts[0].functions_b, *(c.functions_a for c in counts[1:])]),
    }
    most = max(functions.values())
    data = {"contact": name, "points": points, "functions": functions}
    if points < most:
        needed = " and ".join(f"{needed} of {body}" for body, needed in functions.items())
        told = f"{points} points of contacts.{name} cannot resist all gaps of its traces: {needed}"
        yield ResultWarning("under-sampled", told, data)
    # P h / E with the mesh size h and E of the side for which h / E is larger
    spec, interface = scene.contacts[name], halves[0].interface
    sides = zip((spec.a, spec.b), (interface.a, interface.b), strict=True)
    yields = (s.mesh_size / scene.bodies[side.split(".")[0]].material.means[0] for side, s in sides)
    stiffness = _mean(spec, halves) * max(yields)
    if points > most and stiffness > _LOCKS and not nested(interface):
        told = (
            f"{points} points of contacts.{name} lock its {most} trace functions; mortar does not"
        )
        yield ResultWarning("over-constrained", told, data | {"stiffness": stiffness})


def point_rule(name: str, scene: Scene, halves: Sequence[Contact]) -> Iterator[ResultWarning]:
    """A rule that the study of accuracy found too crude at such a stiffness of the contact."""
    spec, dim = scene.contacts[name], halves[0].interface.a.dim
    rule, backend = spec.formulation, scene.bodies[spec.a.split(".")[0]].backend
    stiffness = _relative_stiffness(scene, spec, halves)
    if rule.coupling == "lumped":
        limit = _LUMPED[backend, dim]
        crude, when = stiffness > limit, "above"
    else:
        weights = getattr(rule, "weights", "")
        of_nodes = {"node_to_surface/equal": "nodes", "grid/": "grid"}
        abscissae = weights if rule.method in ("greville", "botella") else ""
        kind = of_nodes.get(f"{rule.method}/{weights}", abscissae)
        limit = _COLLOCATION.get((kind, dim), 0.0)
        crude, when = stiffness < limit, "below"
    if crude:
        where = f"{when} p L / E = {limit:g}, here {stiffness:.2g}"
        if limit in (0.0, inf):
            where = f"at any stiffness, here p L / E = {stiffness:.2g}"
        told = f"{rule.label} in contacts.{name} is too crude for growth rates {where}"
        data = {"contact": name, "rule": rule.label, "stiffness": stiffness, "limit": limit}
        yield ResultWarning("point-rule", told, data)


def short_modes(
    scene: Scene,
    bodies: Mapping[str, Body],
    shapes: Callable[[str, SurfaceCoordinates], Complexes],
    count: int,
) -> tuple[ResultWarning, ...]:
    """Modes whose waves are too short for the elements of a contact; collective."""
    short, worst = np.zeros(count, dtype=bool), 0.0
    for spec in scene.contacts.values() if count else ():
        sides = {}
        for place in (spec.a, spec.b):
            body, surface = place.split(".")
            sides[body] = _waves(bodies[body].surfaces[surface], partial(shapes, place))
        largest = np.max([amplitudes for _, amplitudes in sides.values()], axis=0)
        for body, (phases, amplitudes) in sides.items():
            degree, smooth = _degree(scene.bodies[body])
            found = _unresolved(phases, degree, smooth=smooth, error=_SHORT)
            found &= amplitudes > _STILL * largest
            short |= found
            worst = max(worst, float(phases[found].max(initial=0.0)))
    if not short.any():
        return ()
    numbers, elements = (np.flatnonzero(short) + 1).tolist(), 2 * np.pi / worst
    told = f"{len(numbers)} modes have waves of down to {elements:.2g} elements of their contact"
    data = {"modes": numbers, "elements_per_wave": elements}
    return (ResultWarning("short-modes", told, data),)


def _waves(surface: Surface, shapes: Shapes) -> tuple[Floats, Floats]:
    """Largest phase phi of each mode over the directions of the elements, and its amplitude.

    Along the edges of the elements of a surface, phi^2 = int |du/dxi|^2 / int |u|^2 with xi from 0
    to 1 in each is the square of the phase that a wave passes through in an element. The amplitude
    is the root mean square of the displacements; collective where the shapes are.
    """
    cells = surface.cells()
    steps, corners = max(2, cells.degree), cells.corners
    edges = corners.shape[2]  # one along curves, two along surfaces
    t = np.linspace(0.0, 1.0, steps + 1)[:, None]
    points = np.stack(
        [corners[:, i, None] * (1 - t) + corners[:, i + 1, None] * t for i in range(edges)], axis=1
    )
    element = np.repeat(cells.element, edges * (steps + 1))
    u = shapes(SurfaceCoordinates(element, points.reshape(-1, edges)))
    u = u.reshape(*points.shape[:3], *u.shape[1:])  # cells, edges, points, components, modes
    change = steps**2 * _squares(np.diff(u, axis=2))
    size = _squares(0.5 * (u[:, :, 1:] + u[:, :, :-1]))
    phases = np.sqrt(change / np.maximum(size, np.finfo(float).tiny)).max(axis=0)
    return phases, np.sqrt(size.sum(axis=0) / (len(element) or 1))


def _squares(values: Complexes) -> Floats:
    """Sums of squares for each edge of a cell and each mode."""
    return (np.abs(values) ** 2).sum(axis=(0, 2, 3))


def _unresolved(phases: Floats, degree: int, *, smooth: bool, error: float) -> NDArray[np.bool_]:
    """Which waves are too short for elements of a degree.

    The relative error of their frequency on uniform elements of degree p is, for small phi,

        1/2 (p! / (2 p)!)^2 phi^(2p) / (2 p + 1)      Lagrange elements (Ainsworth 2004)
        1/2 |B_2p| / (2 p)! phi^(2p)          smooth splines (Hughes, Reali & Sangalli 2008)

    with the Bernoulli numbers B: phi^2 / 24 where p = 1, phi^4 / 1440 where p = 2, for both.
    """
    twice, shortest = 2 * degree, _NYQUIST * pi * (1 if smooth else degree)
    if smooth:
        factor = abs(bernoulli(twice)[twice]) / factorial(twice)
    else:
        factor = (factorial(degree) / factorial(twice)) ** 2 / (twice + 1)
    return (0.5 * factor * phases**twice > error) | (phases > shortest)


def _degree(body: BodySpec) -> tuple[int, bool]:
    """Lowest degree of a body's elements, and whether they are smooth splines."""
    iga = body.mesh.iga
    if body.backend == "fe" or iga is None:
        return body.fe_degree or 0, False
    return min(iga.degree), min(iga.continuities) > 0


_ENDS = {
    "x": ("x_min", "x_max"),
    "y": ("y_min", "y_max"),
    "z": ("z_min", "z_max", "bottom", "top", "hub_bottom", "hub_top"),
    "r": ("inner", "outer", "bore", "hub_side"),
}
"""Surfaces that end a body along each direction of its shape."""


def _relative_stiffness(scene: Scene, spec: ContactSpec, halves: Sequence[Contact]) -> float:
    """P (L_a / E_a + L_b / E_b): how much more the bodies yield than the contact.

    L is the depth of a body behind the contact, or the width of the contact where that is less or
    the depth is not known; p the mean contact stiffness (N/m^3), of both halves of a full pass.
    """
    interface = halves[0].interface
    width = float(interface.points.weight.sum()) ** (1 / (interface.a.dim - 1))
    compliance = 0.0
    for side in (spec.a, spec.b):
        body, surface = side.split(".")
        depth = _depth(scene.bodies[body].geometry, surface) or width
        compliance += min(depth, width) / scene.bodies[body].material.means[0]
    return _mean(spec, halves) * compliance


def _mean(spec: ContactSpec, halves: Sequence[Contact]) -> float:
    """Mean contact stiffness p (N/m^3), of steady sliding where a law makes it, open parts too."""
    points = halves[0].interface.points
    area = float(points.weight.sum())
    if spec.c_n is not None:
        return sum(half.P for half in halves) / area
    if isinstance(spec.p, str):
        return float(points.weight @ evaluate(Expression(spec.p), points.x)) / area
    return spec.p if spec.p is not None else (spec.P or 0.0) / area


def _depth(shape: Shape, surface: str) -> float | None:
    """Extent (m) of a body across one of its surfaces; None where its shape does not say."""
    if isinstance(shape, VentilatedDisc):
        return shape.depth(surface)
    if shape.shape in ("patches", "nurbs_file"):
        return None
    for direction, (low, high) in zip(shape.directions, shape.extent, strict=True):
        if surface in _ENDS.get(direction, ()):
            return high - low
    return None
