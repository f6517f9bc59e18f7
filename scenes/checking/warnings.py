"""What the result of a scene must be read with, found in the scene, its contacts and its modes.

A function for each kind of warning. Those of the modes themselves, of their errors and of the
window, come from :mod:`cea.eigen.modes`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from math import inf

import numpy as np

from cea.arrays import Complexes
from cea.body import Body
from cea.contact.contact import Contact
from cea.contact.sampling import nested, sampling
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from cea.warned import ResultWarning
from scenes.building.body_meshes import nodes_left_out
from scenes.checking.contact_stiffness import relative_stiffness, stiffness_in_the_mesh
from scenes.checking.geometry_error import gaps_as_zero
from scenes.checking.motion_warnings import against_rotation, centrifugal_stresses
from scenes.checking.wave_resolution import unresolved, waves
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

_INCOMPRESSIBLE = {("fe", 1): 0.45, ("fe", 2): 0.499, ("iga", 1): 0.45, ("iga", 2): 0.495,
                   ("iga", 3): 0.4999}  # fmt: skip
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
    """Warnings of bodies and contacts, before anything is solved; collective.

    Parameters
    ----------
    scene
        The scene.
    contacts
        Its contacts, both halves of each full pass.
    """
    found = [w for name, body in scene.bodies.items() for w in volumetric_locking(name, body)]
    found += nodes_left_out(scene)
    if scene.analysis.kind == "cea":
        found += centrifugal_stresses(scene)
        found += against_rotation(scene, contacts)
    for name, spec in scene.contacts.items():
        halves = [contact for contact in contacts if contact.pair == name]
        if spec.c_n is None:
            found += gap_closed(name, halves)
        else:
            found += [warning for contact in halves for warning in gaps_as_zero(contact)]
        found += partly_uncovered(name, spec, halves)
        if halves[0].coupling not in ("mortar", "bonded"):
            found += sampled(name, scene, halves)
            if scene.analysis.kind == "cea" and spec.mu:
                found += point_rule(name, scene, halves)
    return tuple(found)


def loads_without_effect(scene: Scene) -> Iterator[ResultWarning]:
    """Loads that press nothing together."""
    if scene.loads and scene.analysis.kind == "cea":
        yield ResultWarning(
            "loads-without-effect",
            "the stiffness of every contact is given: loads change no mode; c_n in the place of P "
            "or p lets them press the sides together",
            {"loads": len(scene.loads)},
        )


def volumetric_locking(name: str, body: BodySpec) -> Iterator[ResultWarning]:
    """A material that keeps its volume, in elements of a degree too low for it."""
    degree, smooth = _degree(body)
    limit = _INCOMPRESSIBLE.get(("iga" if smooth else "fe", degree), inf)
    if body.material.nu >= limit:
        yield ResultWarning(
            "volumetric-locking",
            f"bodies.{name} is nearly incompressible (nu = {body.material.nu:g}); elements of "
            f"degree {degree} are too stiff from nu = {limit:g} on",
            {"body": name, "nu": body.material.nu, "degree": degree, "limit": limit},
        )


def gap_closed(name: str, halves: Sequence[Contact]) -> Iterator[ResultWarning]:
    """Sides that do not touch and are taken to be in contact."""
    interfaces = [contact.interface for contact in halves]
    farthest = max(interface.largest_distance for interface in interfaces)
    size = min(min(i.a.mesh_size, i.b.mesh_size) for i in interfaces)
    if farthest > _CLOSED * size:
        yield ResultWarning(
            "gap-closed",
            f"the sides of contacts.{name} are up to {farthest:.3g} m apart, or as far inside "
            "each other, and are taken to touch",
            {"contact": name, "distance": farthest, "mesh_size": size},
        )


def partly_uncovered(
    name: str, spec: ContactSpec, halves: Sequence[Contact]
) -> Iterator[ResultWarning]:
    """A part of side a that found nothing; the larger side of a full pass is meant to."""
    interface = min((c.interface for c in halves), key=lambda each: each.a.area)
    if not spec.full_pass:
        interface = halves[0].interface
    fraction = 1 - float(interface.points.weight.sum()) / interface.a.area
    if fraction > _UNCOVERED:
        yield ResultWarning(
            "partly-uncovered",
            f"{100 * fraction:.2g} % of {interface.a.name} in contacts.{name} find nothing on the "
            "other side and carry nothing",
            {"contact": name, "fraction": fraction},
        )


def sampled(name: str, scene: Scene, halves: Sequence[Contact]) -> Iterator[ResultWarning]:
    """Points too few for the traces of a side; or too many, at a stiffness at which they lock."""
    counts = [sampling(contact.interface) for contact in halves]
    points = sum(count.points for count in counts)
    functions = {
        halves[0].a: max([counts[0].functions_a, *(c.functions_b for c in counts[1:])]),
        halves[0].b: max([counts[0].functions_b, *(c.functions_a for c in counts[1:])]),
    }
    data = {"contact": name, "points": points, "functions": functions}
    if points < max(functions.values()):
        needed = " and ".join(f"{needed} of {body}" for body, needed in functions.items())
        yield ResultWarning(
            "under-sampled",
            f"{points} points of contacts.{name} cannot resist the gaps of all trace functions "
            f"there: {needed}",
            data,
        )
    stiffness = stiffness_in_the_mesh(scene, name, halves)
    if points > max(functions.values()) and stiffness > _LOCKS and not nested(halves[0].interface):
        yield ResultWarning(
            "over-constrained",
            f"{points} points of contacts.{name} ask more of stiff sides than their "
            f"{max(functions.values())} trace functions can give: they lock, mortar does not",
            data | {"stiffness": stiffness},
        )


def point_rule(name: str, scene: Scene, halves: Sequence[Contact]) -> Iterator[ResultWarning]:
    """A rule that the study of accuracy found too crude at such a stiffness of the contact."""
    spec, dim = scene.contacts[name], halves[0].interface.a.dim
    rule, backend = spec.formulation, scene.bodies[spec.a.split(".")[0]].backend
    stiffness = relative_stiffness(scene, name, halves)
    if rule.coupling == "lumped":
        limit = _LUMPED[backend, dim]
        crude, when = stiffness > limit, "above"
    else:
        limit = _COLLOCATION.get((_kind(rule.method, getattr(rule, "weights", "")), dim), 0.0)
        crude, when = stiffness < limit, "below"
    if crude:
        always = limit in (0.0, inf)
        yield ResultWarning(
            "point-rule",
            f"{rule.label} in contacts.{name} is too crude for growth rates "
            + ("at any stiffness" if always else f"{when} a relative stiffness of {limit:g}")
            + f"; here p L / E = {stiffness:.2g}",
            {"contact": name, "rule": rule.label, "stiffness": stiffness, "limit": limit},
        )


def short_modes(
    scene: Scene,
    bodies: Mapping[str, Body],
    shapes: Callable[[str, SurfaceCoordinates], Complexes],
    count: int,
) -> tuple[ResultWarning, ...]:
    """Modes whose waves are too short for the elements of a contact; collective.

    Parameters
    ----------
    scene
        The scene.
    bodies
        Its bodies.
    shapes
        Displacements of all modes at points of a surface "body.surface", (n, dim, modes).
    count
        Number of modes.
    """
    short, worst = np.zeros(count, dtype=bool), 0.0
    for spec in scene.contacts.values() if count else ():
        sides = {
            place: waves(_surface(bodies, place), partial(shapes, place))
            for place in (spec.a, spec.b)
        }
        largest = np.max([side.amplitudes for side in sides.values()], axis=0)
        for place, side in sides.items():
            degree, smooth = _degree(scene.bodies[place.split(".")[0]])
            moves = side.amplitudes > _STILL * largest
            found = moves & unresolved(side.phases, degree, smooth=smooth, error=_SHORT)
            short |= found
            worst = max(worst, float(side.phases[found].max(initial=0.0)))
    if not short.any():
        return ()
    numbers = (np.flatnonzero(short) + 1).tolist()
    return (
        ResultWarning(
            "short-modes",
            f"{len(numbers)} modes have waves too short for the elements of their contact, down "
            f"to {2 * np.pi / worst:.2g} elements for a wave",
            {"modes": numbers, "elements_per_wave": 2 * np.pi / worst},
        ),
    )


def _surface(bodies: Mapping[str, Body], place: str) -> Surface:
    body, name = place.split(".")
    return bodies[body].surfaces[name]


def _degree(body: BodySpec) -> tuple[int, bool]:
    """Lowest degree of a body's elements, and whether they are smooth splines."""
    degree, iga = body.fe_degree, body.mesh.iga
    if body.backend == "fe" and degree is not None:
        return degree, False
    assert iga is not None
    return min(iga.degree), iga.continuity is None or min(iga.continuity) > 0


def _kind(method: str, weights: str) -> str:
    """Kind of a rule in the table of collocation."""
    if method in ("greville", "botella"):
        return weights
    return {"node_to_surface/equal": "nodes", "grid/": "grid"}.get(f"{method}/{weights}", "")
