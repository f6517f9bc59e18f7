"""Bodies and coupled systems from scenes. A backend is imported only by a scene that uses it."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from cea.arrays import Floats
from cea.body import Body, Space
from cea.contact.contact import Contact
from cea.contact.friction import FrictionDirection, Reversed
from cea.contact.interface import Interface, default_reach, pair
from cea.contact.laws import Friction, LinearLaw, NormalLaw, Sliding
from cea.errors import InputError
from cea.expressions import Expression, evaluate
from cea.petsc import MPI
from cea.ranks import made_on_first
from cea.supports.boundary import Force, Pressure
from cea.surface import Surface
from cea.system.body_terms import Motion
from cea.system.coupled import CoupledSystem, couple
from cea.timing import StageTimer
from meshes.breaks import breaks_of
from meshes.true_surfaces import true_surfaces
from scenes.building.body_meshes import body_mesh
from scenes.building.made_of import BodyParts, Built, PointParts, body_parts, point_parts
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.load import LoadSpec
from scenes.spec.mesh import IgaMesh
from scenes.spec.motion import SlidingSpec
from scenes.spec.reading import Scene

_ROUNDING = 1e-14
"""Friction below this part of the largest counts as zero."""


def reusable_bodies(scene: Scene, given: Mapping[str, Body] | None) -> Mapping[str, Body]:
    """Bodies of those given that are as a scene makes them; others than built ones are taken all.

    Raises
    ------
    InputError
        When the latter have other names than those of the scene.
    """
    if isinstance(given, Built):
        return given.made_of_the_same(_made_of(scene))
    if given is not None and list(given) != list(scene.bodies):
        raise InputError("bodies", list(given), f"those of the scene: {', '.join(scene.bodies)}")
    return given or {}


def _made_of(scene: Scene) -> dict[str, BodyParts]:
    """What the bodies of a scene are made of."""
    return {name: body_parts(scene, name) for name in scene.bodies}


def build_bodies(
    scene: Scene, timer: StageTimer, reused: Mapping[str, Body] | None = None
) -> Mapping[str, Body]:
    """Bodies of a scene by name, some of which are used again."""
    reused = reused or {}
    if list(reused) == list(scene.bodies):
        return reused
    made_of = _made_of(scene)
    with timer("meshing"):
        bodies = {
            name: reused[name]
            if name in reused
            else build_body(name, parts.spec, parts.loads, parts.surfaces)
            for name, parts in made_of.items()
        }
    return Built(bodies, made_of)


def build_body(
    name: str, spec: BodySpec, loads: Sequence[LoadSpec] = (), surfaces: Sequence[str] = ()
) -> Body:
    """One body of a scene on its backend; of a mesh file it has the surfaces that are asked for."""
    if spec.backend == "fe" and spec.fe_degree is not None:
        space = _lagrange_space(name, spec, spec.fe_degree, surfaces)
    elif spec.backend == "iga" and spec.mesh.iga is not None:
        space = _nurbs_space(name, spec, spec.mesh.iga)
    else:
        raise InputError(f"bodies.{name}.mesh.{spec.backend}", None, f"needed for {spec.backend!r}")
    return Body(
        name,
        space,
        spec.material,
        supports=[each.support() for each in spec.supports],
        springs=spec.springs,
        pressures=_pressures(loads),
        forces=_forces(loads),
    )


def _pressures(loads: Sequence[LoadSpec]) -> list[Pressure]:
    return [
        Pressure(load.surface.split(".")[1], load.pressure)
        for load in loads
        if load.surface is not None and load.pressure is not None
    ]


def _forces(loads: Sequence[LoadSpec]) -> list[Force]:
    found = [
        Force(load.force, load.surface.split(".")[1])
        for load in loads
        if load.surface is not None and load.force is not None
    ]
    return found + [Force(load.body_force) for load in loads if load.body_force is not None]


def _lagrange_space(name: str, spec: BodySpec, degree: int, surfaces: Sequence[str]) -> Space:
    from fe_cea import LagrangeSpace

    return LagrangeSpace.from_mesh(
        made_on_first(MPI.COMM_WORLD, lambda: body_mesh(name, spec, surfaces)),
        degree=degree,
        true_surfaces=true_surfaces(spec.geometry, spec.placement),
        field=f"bodies.{name}",
    )


def _nurbs_space(name: str, spec: BodySpec, mesh: IgaMesh) -> Space:
    from iga_cea import NurbsSpace
    from meshes.nurbs_shapes import nurbs_shape

    breaks = breaks_of(spec.geometry, mesh.elements, mesh.through)
    shape = nurbs_shape(spec.geometry, breaks, spec.placement)
    return NurbsSpace(
        shape.patches,
        shape.faces,
        mesh.degree,
        continuity=mesh.continuity,
        field=f"bodies.{name}",
    )


@dataclass(frozen=True)
class _Half:
    """One half of a contact: its points lie on ``a``; ``share`` of the stiffness is its own."""

    name: str
    pair: str
    spec: ContactSpec
    points: PointParts
    direction: FrictionDirection | Reversed | None
    share: float

    @property
    def sides(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Body and surface of side a, and of side b."""
        (body_a, a), (body_b, b) = self.points.a.split("."), self.points.b.split(".")
        return (body_a, a), (body_b, b)

    def surfaces(self, bodies: Mapping[str, Body]) -> tuple[Surface, Surface]:
        """Side a and side b."""
        (body_a, a), (body_b, b) = self.sides
        return bodies[body_a].surfaces[a], bodies[body_b].surfaces[b]


def _halves(contacts: Mapping[str, ContactSpec]) -> Iterator[_Half]:
    """The one half of each half pass, both halves of each full pass."""
    for name, spec in contacts.items():
        direction, share = spec.friction_direction_on_a, 0.5 if spec.full_pass else 1.0
        yield _Half(name, name, spec, point_parts(spec), direction, share)
        if spec.full_pass:
            reversed_ = Reversed(direction) if direction is not None else None
            points = point_parts(spec, opposite=True)
            yield _Half(f"{name}, b on a", name, spec, points, reversed_, share)


def reusable_interfaces(
    scene: Scene, bodies: Mapping[str, Body], given: Mapping[str, Interface] | None
) -> Mapping[str, Interface]:
    """Contact points of those given that are as a scene and its bodies make them.

    Others than built ones are taken all.

    Raises
    ------
    InputError
        When the latter have other names than half passes of the scene, or join other surfaces.
    """
    halves = {half.name: half for half in _halves(scene.contacts)}
    if not isinstance(given, Built):
        if given is not None:
            _check_interfaces(halves, bodies, given)
        return given or {}
    between = {
        name: half.points
        for name, half in halves.items()
        if name in given and not _foreign(given[name], half, bodies)
    }
    return given.made_of_the_same(between)


def _foreign(interface: Interface, half: _Half, bodies: Mapping[str, Body]) -> dict[str, Surface]:
    """Surfaces that an interface joins in the place of those of a half pass, by the latter."""
    pairs = zip((interface.a, interface.b), half.surfaces(bodies), strict=True)
    places = (half.points.a, half.points.b)
    return {
        place: own for place, (own, wanted) in zip(places, pairs, strict=True) if own is not wanted
    }


def _check_interfaces(
    halves: Mapping[str, _Half], bodies: Mapping[str, Body], interfaces: Mapping[str, Interface]
) -> None:
    if interfaces.keys() != halves.keys():
        raise InputError("interfaces", list(interfaces), f"those of {', '.join(halves) or 'none'}")
    for name, interface in interfaces.items():
        for place, own in _foreign(interface, halves[name], bodies).items():
            raise InputError(f"interfaces.{name}", own.name, f"{place} of these bodies")


def build_interfaces(
    scene: Scene,
    bodies: Mapping[str, Body],
    timer: StageTimer,
    reused: Mapping[str, Interface] | None = None,
) -> Mapping[str, Interface]:
    """Contact points of a scene, located on their opposite sides, by name of the half pass.

    Some of them are used again.
    """
    reused, halves = reused or {}, {half.name: half for half in _halves(scene.contacts)}
    if reused and list(reused) == list(halves):
        return reused
    with timer("search"):
        interfaces = {
            name: reused[name] if name in reused else _located(half, bodies)
            for name, half in halves.items()
        }
    return Built(interfaces, {name: half.points for name, half in halves.items()})


def _located(half: _Half, bodies: Mapping[str, Body]) -> Interface:
    """Points of a half pass; of the larger side of a full pass those that find nothing go."""
    parts, (a, b) = half.points, half.surfaces(bodies)
    points = parts.formulation.points_on(a, b, parts.reach or default_reach(a, b))
    larger = parts.full_pass and a.area > b.area
    return pair(
        a,
        b,
        points,
        field=f"contacts.{half.pair}",
        reach=parts.reach,
        max_missed=1.0 if larger else parts.max_missed,
    )


def build_contacts(scene: Scene, interfaces: Mapping[str, Interface]) -> list[Contact]:
    """The half passes of a scene, without operators."""
    return [_contact(half, interfaces[half.name]) for half in _halves(scene.contacts)]


def _contact(half: _Half, interface: Interface) -> Contact:
    """Stiffness and friction at the points; P is spread evenly over those that touch."""
    spec, x = half.spec, interface.points.x
    with _of_contact(half.pair):
        law = _law(spec, interface, half.share)
        added_gap = _values("added_gap", spec.added_gap, x)
        direction = half.direction
        friction = Friction(_friction(spec.mu, x), direction) if direction is not None else None
        sliding = _sliding(spec.sliding, x) if spec.sliding is not None else None
    return Contact(
        name=half.name,
        pair=half.pair,
        a=half.sides[0][0],
        b=half.sides[1][0],
        interface=interface,
        law=law,
        friction=friction,
        coupling=spec.formulation.coupling,
        form=spec.form,
        added_gap=added_gap,
        sliding=sliding,
    )


def _law(spec: ContactSpec, interface: Interface, share: float) -> NormalLaw:
    """Law of a half pass, which has a share of the stiffness."""
    if spec.law is not None:
        return replace(spec.law, c=share * spec.law.c)
    if spec.p is not None:
        return LinearLaw(share * _values("p", spec.p, interface.points.x))
    points = interface.points
    return LinearLaw(share * np.full(len(points), _required(spec.P) / points.weight.sum()))


@contextmanager
def _of_contact(name: str) -> Iterator[None]:
    """Name the contact in faults of its fields."""
    try:
        yield
    except InputError as error:
        raise InputError(f"contacts.{name}.{error.field}", error.value, error.allowed) from None


def _values(name: str, field: float | str, x: Floats) -> Floats:
    """Values of a field of a contact at points."""
    try:
        return evaluate(Expression(field) if isinstance(field, str) else field, x)
    except InputError as error:
        raise InputError(name, error.value, error.allowed) from None


def _friction(mu: float | str, x: Floats) -> Floats:
    """Friction at points; what rounding leaves where an expression vanishes counts as zero."""
    values = _values("mu", mu, x)
    negligible = _ROUNDING * np.abs(values).max(initial=0.0)
    return (
        np.where(np.abs(values) <= negligible, 0.0, values) if np.isfinite(negligible) else values
    )


def _required(value: float | None) -> float:
    if value is None:
        raise InputError("P", None, "either P or p is given")
    return value


def build_system(
    scene: Scene,
    bodies: Mapping[str, Body],
    interfaces: Mapping[str, Interface],
    timer: StageTimer,
    *,
    leave_out: bool = True,
) -> CoupledSystem:
    """Coupled matrices of a scene: mass only for eigenvalues, loads only where they matter."""
    contacts = build_contacts(scene, interfaces)
    static = scene.analysis.kind == "static"
    with timer("assembly"):
        return couple(
            bodies,
            contacts,
            with_mass=not static,
            with_load=static or scene.slides_steadily,
            leave_out=leave_out,
            motions={
                name: _motion(body)
                for name, body in scene.bodies.items()
                if not static or body.rotation is not None  # at rest nothing else moves
            },
        )


def _motion(body: BodySpec) -> Motion:
    """Damping and rotation of a body."""
    if body.damping is None:
        return Motion(rotation=body.rotation)
    return Motion(body.damping.rayleigh(), body.rotation, body.damping.modal)


def _sliding(spec: SlidingSpec, x: Floats) -> Sliding:
    """How a half pass slides, at its points."""
    values = {
        name: _values(f"sliding.{name}", value, x) if value is not None else None
        for name, value in spec.fields.items()
    }
    return Sliding(**values)
