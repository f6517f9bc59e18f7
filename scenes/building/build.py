"""Bodies and coupled systems from scenes. A backend is imported only by a scene that uses it.

A builder of a body or of contact points is given all that these are made of and nothing else of the
scene, so that scenes in which it is equal have the same bodies, or points.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body, Space
from cea.contact.contact import Contact
from cea.contact.formulations import Formulation
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
from meshes.mesh_file import MeshFile
from meshes.true_surfaces import true_surfaces
from scenes.building.body_meshes import body_mesh, used_surfaces
from scenes.spec.body import BodySpec, IgaMesh, LoadSpec
from scenes.spec.contact import ContactSpec, SlidingSpec
from scenes.spec.reading import Scene


@dataclass(frozen=True)
class BodyParts:
    """What a body is made of."""

    spec: BodySpec
    loads: tuple[LoadSpec, ...] = ()
    surfaces: tuple[str, ...] = ()


def body_parts(scene: Scene, name: str) -> BodyParts:
    """What a body of a scene is made of."""
    spec = scene.bodies[name]
    of_file = isinstance(spec.geometry, MeshFile)
    return BodyParts(
        replace(spec, damping=None, rotation=None),
        tuple(load for load in scene.loads if load.on == name),
        tuple(used_surfaces(scene, name)) if of_file else (),
    )


@dataclass(frozen=True)
class PointParts:
    """What the contact points of a half pass are made of, beside the two bodies."""

    a: str
    b: str
    formulation: Formulation
    reach: float | None
    max_missed: float
    full_pass: bool


def point_parts(spec: ContactSpec, *, opposite: bool = False) -> PointParts:
    """What the points of a contact are made of; opposite ones are those of the second half."""
    a, b = (spec.b, spec.a) if opposite else (spec.a, spec.b)
    return PointParts(a, b, spec.formulation, spec.reach, spec.max_missed, spec.full_pass)


class Built[Part](dict[str, Part]):
    """Bodies or contact points by name, with what each was made of."""

    def __init__(self, parts: Mapping[str, Part], made_of: Mapping[str, Any]) -> None:
        super().__init__(parts)
        self.made_of = dict(made_of)

    def made_of_the_same(self, wanted: Mapping[str, Any]) -> "Built[Part]":
        """Those that are made of what is wanted; itself where all are."""
        same = [name for name in wanted if name in self and self.made_of[name] == wanted[name]]
        if same == list(self):
            return self
        return Built({name: self[name] for name in same}, {name: wanted[name] for name in same})


_ROUNDING = 1e-14
"""Friction below this part of the largest counts as zero."""


def build_bodies(
    scene: Scene, timer: StageTimer, given: Mapping[str, Body] | None = None
) -> Mapping[str, Body]:
    """Bodies of a scene by name; of those given they are used again that are made of the same.

    Bodies that no scene built are taken all.

    Raises
    ------
    InputError
        When the latter have other names than those of the scene.
    """
    if given is not None and not isinstance(given, Built):
        if list(given) != list(scene.bodies):
            allowed = f"those of the scene: {', '.join(scene.bodies)}"
            raise InputError("bodies", list(given), allowed)
        return given
    made_of = {name: body_parts(scene, name) for name in scene.bodies}
    reused = given.made_of_the_same(made_of) if given is not None else {}
    if list(reused) == list(made_of):
        return reused
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
        pressures=[
            Pressure(load.surface.split(".")[1], load.pressure)
            for load in loads
            if load.surface is not None and load.pressure is not None
        ],
        forces=[
            Force(force, load.surface.split(".")[1] if load.surface is not None else None)
            for load in loads
            if (force := load.force or load.body_force) is not None
        ],
    )


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

    def surfaces(self, bodies: Mapping[str, Body]) -> tuple[Surface, Surface]:
        """Side a and side b."""
        (body_a, a), (body_b, b) = self.points.a.split("."), self.points.b.split(".")
        return bodies[body_a].surfaces[a], bodies[body_b].surfaces[b]

    def is_joined_by(self, interface: Interface, bodies: Mapping[str, Body]) -> bool:
        """Whether an interface is one between the sides of these bodies."""
        a, b = self.surfaces(bodies)
        return interface.a is a and interface.b is b


def _halves(contacts: Mapping[str, ContactSpec]) -> Iterator[_Half]:
    """The one half of each half pass, both halves of each full pass."""
    for name, spec in contacts.items():
        direction, share = spec.friction_direction_on_a, 0.5 if spec.full_pass else 1.0
        yield _Half(name, name, spec, point_parts(spec), direction, share)
        if spec.full_pass:
            reversed_ = Reversed(direction) if direction is not None else None
            points = point_parts(spec, opposite=True)
            yield _Half(f"{name}, b on a", name, spec, points, reversed_, share)


def build_interfaces(
    scene: Scene,
    bodies: Mapping[str, Body],
    timer: StageTimer,
    given: Mapping[str, Interface] | None = None,
) -> Mapping[str, Interface]:
    """Contact points of a scene, located on their opposite sides, by name of the half pass.

    Of those given they are used again that are made of the same, between these bodies.
    """
    halves = {half.name: half for half in _halves(scene.contacts)}
    reused: Mapping[str, Interface] = {}
    if isinstance(given, Built):
        between = {
            name: half.points
            for name, half in halves.items()
            if name in given and half.is_joined_by(given[name], bodies)
        }
        reused = given.made_of_the_same(between)
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
    spec, points = half.spec, interface.points
    with _of_contact(half.pair):
        law: NormalLaw
        if spec.law is not None:
            law = replace(spec.law, c=half.share * spec.law.c)
        elif spec.p is not None:
            law = LinearLaw(half.share * _values("p", spec.p, points.x))
        else:
            P = spec.P or 0.0  # one of the three is given
            law = LinearLaw(half.share * np.full(len(points), P / points.weight.sum()))
        sliding = _sliding(spec.sliding, points.x) if spec.sliding is not None else None
        friction = None
        if half.direction is not None:
            friction = Friction(_friction(spec.mu, points.x), half.direction)
        return Contact(
            name=half.name,
            pair=half.pair,
            a=half.points.a.split(".")[0],
            b=half.points.b.split(".")[0],
            interface=interface,
            law=law,
            friction=friction,
            coupling=spec.formulation.coupling,
            form=spec.form,
            sliding=sliding,
            added_gap=_values("added_gap", spec.added_gap, points.x),
        )


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
                name: Motion(
                    body.damping.rayleigh() if body.damping is not None else None,
                    body.rotation,
                    body.damping.modal if body.damping is not None else None,
                )
                for name, body in scene.bodies.items()
                if not static or body.rotation is not None  # at rest nothing else moves
            },
        )


def _sliding(spec: SlidingSpec, x: Floats) -> Sliding:
    """How a half pass slides, at its points."""
    values = {
        name: _values(f"sliding.{name}", value, x) if value is not None else None
        for name, value in spec.fields.items()
    }
    return Sliding(**values)
