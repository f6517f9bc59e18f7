"""Checks of a scene that involve more than one field, after each field is valid by itself."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from math import inf
from typing import Any

import numpy as np

from cea.arrays import Floats, of_size_one
from cea.contact.formulations import registered
from cea.errors import InputError, did_you_mean, require
from cea.expressions import Expression
from cea.motion import Rotation
from cea.supports.boundary import Support, check_surface
from meshes.breaks import TOO_FEW, breaks_of, fit, run_along
from meshes.mesh_file import MeshFile, check_unit
from meshes.patches import NurbsFile
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.spec.body import BodySpec, FeMesh, IgaMesh, MeshSpec
from scenes.spec.contact import ContactSpec, suits
from scenes.spec.plain import leaves
from scenes.spec.problems import Faults

Scene = Any
""":class:`scenes.spec.reading.Scene`, whose module imports this one."""

LARGEST, SMALLEST = 1e30, 1e-30
"""Allowed absolute values of nonzero numbers. Lengths, stiffnesses and densities in any units fit,
and products of a few of them neither overflow nor underflow."""
MAX_ELEMENTS = 10**6
"""Largest number of elements along one direction."""
_LONGEST = 100
"""Largest number of characters in a name."""
_PARTING = set(".,[] ")
"""Separators of the names in a path, not allowed in names."""
_SCALES = (
    *("E", "rho", "P", "p", "c_n", "max_frequency", "speed", "frequencies"),
    *("size", "inner_radius", "outer_radius", "bore", "hub_radius", "reach"),
)
"""Fields that set scales, which must not be nearly zero; coordinates and directions may be."""
_LARGEST_OF = {"c_n": 1e90, "m_n": 20.0}
"""Upper limits of single fields; c_n is a pressure divided by a small length to the power m_n."""
_THIN = 1e-12
"""Smallest extent of a shape along a coordinate, relative to the coordinate's magnitude."""
_CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}
_AXISYMMETRIC = ("annulus", "hub", "disc", "ring")
"""Shapes that are axisymmetric with all their surfaces."""
_ASIDE = 1e-9
"""Tolerance of coincident axes: distance relative to the radius of the shape, sine of the angle.
Also the relative tolerance of axisymmetric tensors."""
_ALIKE = "axisymmetric about the axis of rotation where a body that rotates is damped"

_Tensor = Callable[[Floats, Floats, Floats], Floats]
"""Function of a point (1, dim), a normal (1, dim) and the rotation (dim, dim) of the body that
returns a matrix."""
_NEEDS = "left out where no contact has c_n: no state of steady sliding is computed"


def consistent[S: Any](scene: S) -> S:
    """Return the scene; raise a SceneError if its fields contradict each other."""
    faults = Faults()
    need = faults.require
    _limit_checks(faults, scene)
    need(bool(scene.bodies), "bodies", {}, "at least one body")
    for name, body in scene.bodies.items():
        _body_checks(faults, f"bodies.{name}", body)
        if isinstance(body.geometry, MeshFile | NurbsFile):
            place, si = f"bodies.{name}.geometry", scene.units == "SI"
            faults.of(partial(check_unit, body.geometry.unit, place, si=si))
        if scene.analysis.kind == "cea" or body.rotates_in_equilibrium:
            faults.of(body.material.density, f"bodies.{name}.material")
    known = sorted(f"{n}.{s}" for n, body in scene.bodies.items() for s in body.geometry.surfaces)
    pairs: dict[frozenset[str], str] = {}
    for name, contact in scene.contacts.items():
        _contact_checks(faults, scene, f"contacts.{name}", contact, known)
        _slip_checks(faults, scene, f"contacts.{name}", contact)
        first = pairs.setdefault(frozenset((contact.a, contact.b)), name)
        allowed = f"sides other than those of contacts.{first}, which joins the same surfaces"
        need(first == name, f"contacts.{name}.a", f"{contact.a} on {contact.b}", allowed)
    for i, load in enumerate(scene.loads):
        place = f"loads.{i}"
        if load.surface is not None:
            faults.of(check_surface, load.surface, known, f"{place}.surface")
        else:
            allowed = f"one of {', '.join(scene.bodies)}{did_you_mean(load.body, scene.bodies)}"
            need(load.body in scene.bodies, f"{place}.body", load.body, allowed)
        if load.on in scene.bodies:
            lists = {f"{place}.force": load.force, f"{place}.body_force": load.body_force}
            _length_checks(faults, lists, scene.bodies[load.on].dim, "the components")
    if not scene.slides_steadily:
        _steady_checks(faults, scene)
    faults.refuse()
    return scene


def _limit_checks(faults: Faults, scene: Scene) -> None:
    """Check the lengths and characters of names and the magnitudes of numbers."""
    need = faults.require
    check_scene_name(faults, scene.name)
    names = [(kind, name) for kind in ("bodies", "contacts") for name in getattr(scene, kind)]
    for name, body in scene.bodies.items():
        names += [(f"bodies.{name}.geometry.faces", each) for each in body.geometry.surfaces]
    allowed = f"1 to {_LONGEST} printable characters, no dot, comma, bracket or blank"
    for place, name in names:
        fits = 0 < len(name) <= _LONGEST and name.isprintable() and not set(name) & _PARTING
        need(fits, place, name, allowed)
    for place, number in leaves(asdict(scene)):
        if isinstance(number, int | float):
            field = next(part for part in reversed(place.split(".")) if not part.isdecimal())
            largest, tied = _LARGEST_OF.get(field, LARGEST), field in ("P", "p") and number == inf
            need(abs(number) <= largest or tied, place, number, f"at most {largest:g}")
            vanishes = field in _SCALES and 0 < abs(number) < SMALLEST
            need(not vanishes, place, number, f"at least {SMALLEST:g}")


def check_scene_name(faults: Faults, name: str) -> None:
    """Check the name of a scene, which is used in file names and terminal output."""
    fits = 0 < len(name.strip()) <= len(name) <= _LONGEST and name.isprintable()
    faults.require(fits, "name", name, f"a name of 1 to {_LONGEST} printable characters")


def _length_checks(
    faults: Faults, lists: Mapping[str, Sequence[float] | None], dim: int, each: str
) -> None:
    """Require ``dim`` entries in each list."""
    for place, values in lists.items():
        fits = values is None or len(values) == dim
        faults.require(fits, place, values, f"{dim} numbers, one for each of {each}")


def _body_checks(faults: Faults, place: str, body: BodySpec) -> None:
    """Check mesh, placement, supports, springs and rotation of a body against its shape."""
    shape, known, mesh, dim = body.geometry, body.geometry.surfaces, body.mesh, body.dim
    before, need = len(faults), faults.require
    for name, (low, high) in zip(shape.directions, shape.extent, strict=True):
        wide, span = high - low > _THIN * max(abs(low), abs(high)), f"{name} from {low} to {high}"
        need(wide, f"{place}.geometry", span, "a range larger than rounding")
    if len(faults) == before:
        _mesh_checks(faults, f"{place}.mesh", body)
    faults.of(body.placement.check, dim, f"{place}.placement")
    faults.of(body.material.elasticity.check, dim, f"{place}.material")
    for i, support in enumerate(body.supports):
        faults.of(support.check, dim, f"{place}.supports.{i}")
        faults.of(check_surface, support.surface, known, f"{place}.supports.{i}.surface")
    for i, spring in enumerate(body.springs):
        lists = {f"{place}.springs.{i}.stiffness": spring.stiffness}
        _length_checks(faults, lists, dim, "the components")
        faults.of(check_surface, spring.surface, known, f"{place}.springs.{i}.surface")
    if body.rotation is not None:
        _rotation_checks(faults, place, body, body.rotation)
    suited = ("iga",) if shape.shape in ("patches", "nurbs_file") else ("fe", "iga")
    suited = ("fe",) if isinstance(shape, MeshFile | VentilatedDisc) else suited
    allowed = f"{suited[0]!r} for shape = {shape.shape!r}"
    need(body.backend in suited, f"{place}.backend", body.backend, allowed)
    if isinstance(shape, MeshFile):
        return
    given, some = body.division is not None, mesh != MeshSpec()
    need(some, f"{place}.mesh", None, "field required, except for a mesh file")
    allowed = f"needed for {body.backend!r}"
    need(given or not some, f"{place}.mesh.{body.backend}", None, allowed)


def _rotation_checks(faults: Faults, place: str, body: BodySpec, rotation: Rotation) -> None:
    """Require that a rotating body is axisymmetric about its axis of rotation."""
    shape, dim, damping = body.geometry.shape, body.dim, body.damping
    faults.of(rotation.check, dim, f"{place}.rotation")
    allowed = f"{', '.join(_AXISYMMETRIC)} to rotate"
    faults.require(shape in _AXISYMMETRIC, f"{place}.geometry.shape", shape, allowed)
    if any(each.field.startswith(f"{place}.") for each in faults):
        return
    axis, here = body.placement.rotation[:, 2], body.placement.translation
    given = of_size_one(rotation.axis)
    parallel = bool(np.linalg.norm(np.cross(axis, given)) <= _ASIDE * np.linalg.norm(given))
    allowed = f"along {axis.tolist()}"
    faults.require(parallel, f"{place}.rotation.axis", rotation.axis, allowed)
    arm = np.cross(axis, np.array([*rotation.origin, 0.0])[:3] - here)
    on_axis = bool(np.linalg.norm(arm) <= _ASIDE * body.geometry.extent[0][1])
    allowed = f"a point on the axis of the body, e.g. {list(here)}"
    faults.require(on_axis, f"{place}.rotation.origin", rotation.origin, allowed)
    law, strains = body.material.elasticity, np.square(np.arange(1.0, dim**2 + 1))

    def stress(x: Floats, _: Floats, turn: Floats) -> Floats:
        gradient = turn @ strains.reshape(dim, dim) @ turn.T
        return law.stress(gradient[..., None], x.T)[..., 0]

    alike, allowed = _turns(stress, rotation, dim), "axisymmetric about the axis of rotation"
    faults.require(alike, f"{place}.material", body.material.kind, allowed)
    for i, support in enumerate(body.supports):
        at_rest = not (body.rotates_in_equilibrium and support.prescribes)
        allowed = "zero where a body rotates with damping or convective stiffness"
        faults.require(at_rest, f"{place}.supports.{i}.value", support.value, allowed)

        def held(x: Floats, normal: Floats, _: Floats, support: Support = support) -> Floats:
            directions = support.directions(x, normal)[:, 0]
            return directions.T @ directions

        alike = damping is None or _turns(held, rotation, dim)
        faults.require(alike, f"{place}.supports.{i}", list(support.components), _ALIKE)
    for i, spring in enumerate(body.springs if damping is not None and damping.modal else ()):
        stiffness = spring.stiffness
        alike = _turns(lambda *_, k=stiffness: np.diag(k), rotation, dim)
        allowed = f"{_ALIKE} by modal damping"
        faults.require(alike, f"{place}.springs.{i}.stiffness", stiffness, allowed)


def _turns(tensor: _Tensor, rotation: Rotation, dim: int) -> bool:
    """Whether a tensor field is axisymmetric, tested at one point rotated by 1 rad."""
    spin, origin = rotation.spin(dim), np.asarray(rotation.origin[:dim], dtype=float)
    turn = np.eye(dim) + np.sin(1.0) * spin + (1 - np.cos(1.0)) * spin @ spin
    arm, normal = np.sqrt([[2.0, 3.0, 5.0], [0.5, 0.3, 0.2]])[:, None, :dim]  # in general position
    here = turn @ tensor(origin + arm, normal, np.eye(dim)) @ turn.T
    there = tensor(origin + arm @ turn.T, normal @ turn.T, turn)
    return bool(np.abs(here - there).max() <= _ASIDE * np.abs(here).max())


def _mesh_checks(faults: Faults, place: str, body: BodySpec) -> None:
    """Check cells, numbers and sizes of elements against the shape."""
    shape, fe, iga, degree = body.geometry, body.mesh.fe, body.mesh.iga, body.mesh.degree
    need = faults.require
    if isinstance(shape, MeshFile):
        allowed = "left out: cells are those of the file; mesh.degree may be given"
        need(fe is None, f"{place}.fe", fe, allowed)
        need(iga is None, f"{place}.iga", iga, allowed)
        return
    allowed = "left out, except for a mesh file: use fe.degree or iga.degree"
    need(degree is None, f"{place}.degree", degree, allowed)
    if fe is not None and fe.size is not None and body.backend == "fe":
        most = max(body.lengths)
        allowed = f"{most / MAX_ELEMENTS:.3g} to {most:.3g} (m), the length of the body"
        need(most / MAX_ELEMENTS <= fe.size <= most, f"{place}.fe.size", fe.size, allowed)
    if isinstance(shape, VentilatedDisc):
        if fe is not None:  # unstructured
            tetrahedra, curved = fe.cell == "tetrahedron", fe.geometry_degree or fe.degree
            need(tetrahedra, f"{place}.fe.cell", fe.cell, "tetrahedron for this shape")
            sized, allowed = fe.size is not None, "left out for this shape: give size"
            need(sized or not tetrahedra, f"{place}.fe.elements", fe.elements, allowed)
            allowed = f"1 to {MAX_CURVED} for this shape, independent of the degree of the elements"
            at = f"{place}.fe.geometry_degree"
            need(curved <= MAX_CURVED, at, fe.geometry_degree, allowed)
        return
    lists: dict[str, tuple[int, ...] | None] = {}
    if fe is not None:
        cells = _CELLS[body.dim]
        need(fe.cell in cells, f"{place}.fe.cell", fe.cell, " or ".join(cells))
        lists[f"{place}.fe.elements"] = fe.elements
    if iga is not None:
        lists[f"{place}.iga.degree"] = iga.degree
        lists[f"{place}.iga.elements"] = iga.elements
        lists[f"{place}.iga.continuity"] = iga.continuity
    _length_checks(faults, lists, body.dim, ", ".join(shape.directions))
    for name, one in (("fe", fe), ("iga", iga)):
        if one is not None and one.elements is not None and len(one.elements) == body.dim:
            _elements_checks(faults, f"{place}.{name}", body, one)


def _elements_checks(faults: Faults, place: str, body: BodySpec, mesh: FeMesh | IgaMesh) -> None:
    """Check numbers of elements, element boundaries and singular edges."""
    elements, shape = mesh.elements or (), body.geometry
    if not all(1 <= count <= MAX_ELEMENTS for count in elements):
        allowed = f"1 to {MAX_ELEMENTS} along each direction"
        faults.append(InputError(f"{place}.elements", elements, allowed))
        return
    edges = mesh.edges if isinstance(mesh, FeMesh) else ()
    through = mesh.boundaries if isinstance(mesh, FeMesh) else mesh.through
    try:
        if edges:
            run_along(shape, edges)
        breaks = breaks_of(shape, elements, through)
        if edges:
            require(fit(shape, breaks, edges), "elements", elements, TOO_FEW)
    except InputError as fault:
        value = tuple(elements) if fault.field == "elements" else fault.value
        faults.append(InputError(f"{place}.{fault.field}", value, fault.allowed))


def _contact_checks(
    faults: Faults, scene: Scene, place: str, contact: ContactSpec, known: Sequence[str]
) -> None:
    """Check the sides, formulation, friction direction and expressions of a contact."""
    sides = dict(zip("ab", contact.sides, strict=True))
    for side in sides:
        faults.of(check_surface, getattr(contact, side), known, f"{place}.{side}")
    two = sides["a"][0] != sides["b"][0]
    faults.require(two, f"{place}.b", contact.b, f"a surface of another body than {contact.a}")
    bodies = {side: scene.bodies[n] for side, (n, _) in sides.items() if n in scene.bodies}
    for side, body in bodies.items() if two else ():
        name, surface = sides[side]
        for i, support in enumerate(body.supports if f"{name}.{surface}" in known else ()):
            held = len(set(support.components)) in (0, body.dim) or "normal" in support.components
            allowed = f"a surface that may move: bodies.{name}.supports.{i} holds it"
            moves = not held or support.surface != surface
            faults.require(moves, f"{place}.{side}", getattr(contact, side), allowed)
        if contact.full_pass or side == "a":
            method, fits = contact.formulation.method, suits(contact.formulation, body.backend)
            others = [each for each, kind in registered().items() if suits(kind, body.backend)]
            allowed = f"one of {', '.join(others)} where side {side} has backend {body.backend!r}"
            faults.require(fits, f"{place}.formulation.method", method, allowed)
    sliding, fields = contact.sliding, {"p": contact.p, "mu": contact.mu}
    if sliding is not None:
        fields |= {f"sliding.{name}": value for name, value in asdict(sliding).items()}
        either = (sliding.pressure is None) != (contact.c_n is None)
        allowed = "either the contact pressure (N/m^2) or c_n, with which the loads determine it"
        faults.require(either, f"{place}.sliding.pressure", sliding.pressure, allowed)
    speed = sliding and sliding.speed
    dims = {body.dim for body in bodies.values()}
    allowed = f"a body of the same dimension as {contact.a}"
    faults.require(len(dims) < 2, f"{place}.b", contact.b, allowed)
    for dim in dims if len(dims) == 1 else ():
        if (direction := contact.friction_direction_on_a) is not None:
            faults.of(direction.check, dim, f"{place}.friction_direction_on_a")
        allowed = "left out in the plane, where the sliding direction cannot change"
        faults.require(dim == 3 or speed is None, f"{place}.sliding.speed", speed, allowed)
        for name, value in fields.items():
            if isinstance(value, str):
                faults.of(Expression(value).check, f"{place}.{name}", dim)


def _slip_checks(faults: Faults, scene: Scene, place: str, contact: ContactSpec) -> None:
    """Refuse bonded sides that rotate differently, and friction of sides that rotate alike."""
    names = [name for name, _ in contact.sides if name in scene.bodies]
    if len(names) < 2:
        return
    (spin, moment), (other_spin, other_moment) = (_rotation_of(scene.bodies[n]) for n in names)
    reach = scene.bodies[names[0]].geometry.extent[0][1] if spin.any() and other_spin.any() else 0.0
    rate, both = float(np.linalg.norm(spin)), f"bodies.{names[0]} and bodies.{names[1]}"
    alike = bool(np.linalg.norm(spin - other_spin) <= _ASIDE * rate)
    alike &= bool(np.linalg.norm(moment - other_moment) <= _ASIDE * rate * reach)
    bonded = contact.formulation.coupling == "bonded"
    allowed = f"one that is not bonded, unless {both} have the same rotation (rate, axis, origin)"
    faults.require(alike or not bonded, f"{place}.formulation.method", "bonded", allowed)
    direction, slides = contact.friction_direction_on_a, contact.mu != 0 or contact.sliding
    if direction is None or not slides or not alike or not rate:
        return
    vector = of_size_one(getattr(direction, "vector", (1.0, 0.0)))
    size = _ASIDE * rate * float(np.linalg.norm(vector))
    along = len(vector) == 3 and bool(np.linalg.norm(np.cross(spin, vector)) <= size)
    allowed = f"a vector along the axis, or mu = 0: {both} have the same rotation and do not slide"
    faults.require(along, f"{place}.friction_direction_on_a", asdict(direction), allowed)


def _rotation_of(body: BodySpec) -> tuple[Floats, Floats]:
    """Return the angular velocity (rad/s) of a body and its moment about x = 0 (m/s), zero at rest.

    The moment is the velocity of the rotation, continued to x = 0.
    """
    if body.rotation is None:
        return np.zeros(3), np.zeros(3)
    axis = of_size_one(body.rotation.axis)
    spin = body.rotation.rate * axis / np.linalg.norm(axis)
    return spin, np.cross(body.rotation.origin, spin)


def _steady_checks(faults: Faults, scene: Scene) -> None:
    """Refuse fields that have no effect without a state of steady sliding."""
    check_no_steady_state(faults, scene.analysis, _NEEDS)
    static, pictures = scene.analysis.kind == "static", scene.output.pictures
    allowed = "0 in a static analysis where no contact has c_n"
    faults.require(not (static and pictures), "output.pictures", pictures, allowed)
    for name, body in scene.bodies.items():
        for i, support in enumerate(body.supports):
            free = static or support.value is None
            faults.require(free, f"bodies.{name}.supports.{i}.value", support.value, _NEEDS)


def check_no_steady_state(faults: Faults, analysis: Any, allowed: str) -> None:
    """Check that an analysis has no field that needs a state of steady sliding."""
    steps = analysis.load_steps
    faults.require(steps is None, "analysis.load_steps", steps, allowed)
    stiffens = analysis.kind == "cea" and analysis.geometric_stiffness
    faults.require(not stiffens, "analysis.geometric_stiffness", True, allowed)
