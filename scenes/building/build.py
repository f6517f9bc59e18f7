"""Bodies and coupled systems from scenes. A backend is imported only by a scene that uses it.

What a body or the points of a half pass are made of is kept beside them: scenes in which it is
equal have the same bodies, or points.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body, Space
from cea.contact.contact import Contact
from cea.contact.friction import Friction
from cea.contact.interface import Interface, default_reach, pair
from cea.contact.laws import LinearLaw, NormalLaw, Sliding
from cea.errors import InputError, require
from cea.expressions import Expression, evaluate
from cea.mesh import Mesh
from cea.motion import Motion
from cea.petsc import MPI
from cea.ranks import made_on_first
from cea.supports.boundary import Force, Pressure
from cea.surface import Surface
from cea.system.coupled import CoupledSystem, couple
from cea.timing import StageTimer
from meshes.breaks import breaks_of
from meshes.mesh_file import MeshFile
from meshes.true_surfaces import true_surfaces
from scenes.spec.body import BodySpec, LoadSpec
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

_ROUNDING = 1e-14
"""Friction below this part of the largest counts as zero."""


class Built[Part](dict[str, Part]):
    """Bodies or contact points by name, with what each was made of."""

    def __init__(self, parts: Mapping[str, Part], made_of: Mapping[str, Any]) -> None:
        super().__init__(parts)
        self.made_of = dict(made_of)


def _alike[Part](given: Mapping[str, Part] | None, wanted: Mapping[str, Any]) -> dict[str, Part]:
    if not isinstance(given, Built):
        return {}
    return {name: given[name] for name in wanted if given.made_of.get(name) == wanted[name]}


def made_of(scene: Scene, name: str) -> tuple[BodySpec, tuple[LoadSpec, ...], tuple[str, ...]]:
    """What a body of a scene is made of: its spec, its loads, surfaces asked of a mesh file."""
    spec = scene.bodies[name]
    of_file = isinstance(spec.geometry, MeshFile)
    return (
        replace(spec, damping=None, rotation=None),
        tuple(load for load in scene.loads if load.on == name),
        tuple(used_surfaces(scene, name)) if of_file else (),
    )


def build_bodies(
    scene: Scene, timer: StageTimer, given: Mapping[str, Body] | None = None
) -> Mapping[str, Body]:
    """Bodies of a scene by name; of those given they are used again that are made of the same.

    Bodies that no scene built are taken all, and refused where their names are others.
    """
    if given is not None and not isinstance(given, Built):
        names, allowed = list(scene.bodies), f"those of the scene: {', '.join(scene.bodies)}"
        require(list(given) == names, "bodies", list(given), allowed)
        return given
    wanted = {name: made_of(scene, name) for name in scene.bodies}
    alike = _alike(given, wanted)
    if list(alike) == list(wanted):
        return Built(alike, wanted)
    with timer("meshing"):
        bodies = {n: alike.get(n) or build_body(n, *parts) for n, parts in wanted.items()}
    return Built(bodies, wanted)


def build_body(
    name: str, spec: BodySpec, loads: Sequence[LoadSpec] = (), surfaces: Sequence[str] = ()
) -> Body:
    """One body of a scene on its backend; of a mesh file it has the surfaces that are asked for."""
    field, mesh, degree = f"bodies.{name}", spec.mesh.iga, spec.fe_degree
    space: Space
    if spec.backend == "fe" and degree is not None:
        from fe_cea import LagrangeSpace

        space = LagrangeSpace.from_mesh(
            made_on_first(MPI.COMM_WORLD, lambda: body_mesh(name, spec, surfaces)),
            degree=degree,
            true_surfaces=true_surfaces(spec.geometry, spec.placement),
            field=field,
        )
    elif spec.backend == "iga" and mesh is not None:
        from iga_cea import NurbsSpace
        from meshes.nurbs_shapes import nurbs_shape

        breaks = breaks_of(spec.geometry, mesh.elements, mesh.through)
        shape, c = nurbs_shape(spec.geometry, breaks, spec.placement), mesh.continuity
        space = NurbsSpace(shape.patches, shape.faces, mesh.degree, continuity=c, field=field)
    else:
        raise InputError(f"{field}.mesh.{spec.backend}", None, f"needed for {spec.backend!r}")
    places = [((each.surface or "").partition(".")[2], each) for each in loads]
    forces = [(place or None, each.force or each.body_force) for place, each in places]
    return Body(
        name,
        space,
        spec.material,
        supports=spec.supports,
        springs=spec.springs,
        pressures=[Pressure(at, each.pressure) for at, each in places if each.pressure is not None],
        forces=[Force(force, at) for at, force in forces if force is not None],
    )


def used_surfaces(scene: Scene, body: str) -> list[str]:
    """Surfaces of a body that supports, springs, loads and contacts name."""
    spec = scene.bodies[body]
    places = [load.surface for load in scene.loads if load.surface is not None]
    places += [side for contact in scene.contacts.values() for side in (contact.a, contact.b)]
    own = [place.partition(".")[2] for place in places if place.partition(".")[0] == body]
    held = [support.surface for support in spec.supports]
    held += [spring.surface for spring in spec.springs]
    return list(dict.fromkeys([*held, *own]))


def body_mesh(body: str, spec: BodySpec, surfaces: Iterable[str]) -> Mesh:
    """Mesh of a body of Lagrange elements; of a mesh file, with the surfaces that are asked for."""
    if isinstance(spec.geometry, MeshFile):
        with below(f"bodies.{body}.geometry"):
            return spec.geometry.mesh(surfaces, spec.placement)
    from meshes.shape_mesh import shape_mesh

    fe = spec.mesh.fe
    if fe is None:
        raise InputError(f"bodies.{body}.mesh.fe", None, "needed for 'fe'")
    breaks = None
    if fe.elements is not None:
        breaks = breaks_of(spec.geometry, fe.elements, fe.boundaries)
    return shape_mesh(
        spec.geometry,
        fe.cell,
        fe.geometry_degree or fe.degree,
        breaks=breaks,
        size=fe.size,
        placement=spec.placement,
        edges=fe.edges,
        layers=fe.layers,
    )


@dataclass(frozen=True)
class _Half:
    """One half of a contact: its points lie on ``a``; ``share`` of the stiffness is its own."""

    name: str
    pair: str
    spec: ContactSpec
    a: str
    b: str
    share: float = 1.0
    reverse: bool = False  # whether the points lie on side b of the contact

    @property
    def made_of(self) -> tuple[Any, ...]:
        """What its points are made of, beside the two bodies."""
        spec = self.spec
        return self.a, self.b, spec.formulation, spec.reach, spec.max_missed, spec.full_pass

    def surfaces(self, bodies: Mapping[str, Body]) -> tuple[Surface, Surface]:
        """Side a and side b."""
        (body_a, a), (body_b, b) = self.a.split("."), self.b.split(".")
        return bodies[body_a].surfaces[a], bodies[body_b].surfaces[b]


def _halves(contacts: Mapping[str, ContactSpec]) -> Iterator[_Half]:
    """The one half of each half pass, both halves of each full pass."""
    for name, spec in contacts.items():
        share = 0.5 if spec.full_pass else 1.0
        yield _Half(name, name, spec, spec.a, spec.b, share)
        if spec.full_pass:
            yield _Half(f"{name}, b on a", name, spec, spec.b, spec.a, share, reverse=True)


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
    wanted = {name: half.made_of for name, half in halves.items()}
    alike = {
        name: interface
        for name, interface in _alike(given, wanted).items()
        if (interface.a, interface.b) == halves[name].surfaces(bodies)
    }
    if alike and list(alike) == list(halves):
        return Built(alike, wanted)
    with timer("search"):
        found = {n: alike.get(n) or _located(half, bodies) for n, half in halves.items()}
    return Built(found, wanted)


def _located(half: _Half, bodies: Mapping[str, Body]) -> Interface:
    """Points of a half pass; of the larger side of a full pass those that find nothing go."""
    spec, (a, b) = half.spec, half.surfaces(bodies)
    points = spec.formulation.points_on(a, b, spec.reach or default_reach(a, b))
    missed = 1.0 if spec.full_pass and a.area > b.area else spec.max_missed
    field = f"contacts.{half.pair}"
    return pair(a, b, points, field=field, reach=spec.reach, max_missed=missed)


def build_contacts(scene: Scene, interfaces: Mapping[str, Interface]) -> list[Contact]:
    """The half passes of a scene, without operators."""
    return [_contact(half, interfaces[half.name]) for half in _halves(scene.contacts)]


def _contact(half: _Half, interface: Interface) -> Contact:
    """Stiffness and friction at the points; P is spread evenly over those that touch."""
    spec, points = half.spec, interface.points
    with below(f"contacts.{half.pair}"):
        law: NormalLaw
        if spec.law is not None:
            law = replace(spec.law, c=half.share * spec.law.c)
        else:
            p = spec.p if spec.p is not None else (spec.P or 0.0) / float(points.weight.sum())
            law = LinearLaw(half.share * _values("p", p, points.x))
        sliding = None
        if spec.sliding is not None:
            given = {n: value for n, value in spec.sliding.fields.items() if value is not None}
            sliding = Sliding(**{n: _values(f"sliding.{n}", v, points.x) for n, v in given.items()})
        friction = None
        if spec.friction_direction_on_a is not None:
            mu = _values("mu", spec.mu, points.x)
            # what rounding leaves where an expression vanishes counts as zero
            negligible = np.abs(mu) < _ROUNDING * np.abs(mu).max(initial=0.0)
            mu = np.where(negligible, 0.0, mu)
            friction = Friction(mu, spec.friction_direction_on_a, half.reverse)
        return Contact(
            name=half.name,
            pair=half.pair,
            a=half.a.split(".")[0],
            b=half.b.split(".")[0],
            interface=interface,
            law=law,
            friction=friction,
            coupling=spec.formulation.coupling,
            form=spec.form,
            sliding=sliding,
            added_gap=_values("added_gap", spec.added_gap, points.x),
        )


@contextmanager
def below(place: str) -> Iterator[None]:
    """Name the section in faults of its fields."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}.{error.field}", error.value, error.allowed) from None


def _values(name: str, field: float | str, x: Floats) -> Floats:
    try:
        return evaluate(Expression(field) if isinstance(field, str) else field, x)
    except InputError as error:
        raise InputError(name, error.value, error.allowed) from None


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
    motions = {}
    for name, body in scene.bodies.items():
        damping = body.damping
        if not static or body.rotation is not None:  # at rest nothing else moves
            rayleigh, modal = (damping.rayleigh(), damping.modal) if damping else (None, None)
            motions[name] = Motion(rayleigh, body.rotation, modal)
    with timer("assembly"):
        return couple(
            bodies,
            contacts,
            with_mass=not static,
            with_load=static or scene.slides_steadily,
            leave_out=leave_out,
            motions=motions,
        )
