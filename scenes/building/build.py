"""Bodies and coupled systems of scenes. A backend is imported only if a scene uses it."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body, Space
from cea.contact.contact import Contact
from cea.contact.interface import default_reach, pair
from cea.contact.pressure_and_friction import Friction, LinearLaw, NormalLaw, Sliding
from cea.errors import InputError, require
from cea.expressions import evaluate
from cea.mesh import Mesh
from cea.motion import Motion
from cea.petsc import MPI
from cea.ranks import made_on_first
from cea.supports.boundary import Force, Pressure
from cea.system.coupled import CoupledSystem, couple
from cea.timing import StageTimer
from meshes.breaks import breaks_of
from meshes.mesh_file import MeshFile
from meshes.true_surfaces import true_surfaces
from scenes.spec.body import BodySpec, LoadSpec
from scenes.spec.contact import B_ON_A, ContactSpec
from scenes.spec.reading import Scene

_ROUNDING = 1e-14
"""Friction coefficient, relative to the largest of a contact, below which it is set to zero."""


def made_of(scene: Scene, name: str) -> tuple[BodySpec, tuple[LoadSpec, ...], tuple[str, ...]]:
    """Return what determines a body: its spec, loads, and surfaces used from a mesh file."""
    spec = scene.bodies[name]
    of_file = isinstance(spec.geometry, MeshFile)
    return (
        replace(spec, damping=None, rotation=None),
        tuple(load for load in scene.loads if load.on == name),
        tuple(used_surfaces(scene, name)) if of_file else (),
    )


def build_bodies(
    scene: Scene, timer: StageTimer, given: Mapping[str, Body] | None = None
) -> dict[str, Body]:
    """Return the bodies of a scene by name.

    Given bodies are reused if they were built from the same data, or without a scene.
    """
    bodies, given = {}, given or {}
    if any(body.made_of is None for body in given.values()):
        allowed = f"those of the scene: {', '.join(scene.bodies)}"
        require(sorted(given) == sorted(scene.bodies), "bodies", list(given), allowed)
    for name in scene.bodies:
        wanted, body = made_of(scene, name), given.get(name)
        if body is None or body.made_of not in (None, wanted):
            with timer("meshing"):
                body = replace(build_body(name, *wanted), made_of=wanted)
        bodies[name] = body
    return bodies


def build_body(
    name: str, spec: BodySpec, loads: Sequence[LoadSpec] = (), surfaces: Sequence[str] = ()
) -> Body:
    """Build a body of a scene on its backend; ``surfaces`` are those used from a mesh file."""
    field, mesh = f"bodies.{name}", spec.mesh.iga
    space: Space
    if spec.backend == "fe":
        from fe_cea import LagrangeSpace

        space = LagrangeSpace.from_mesh(
            made_on_first(MPI.COMM_WORLD, lambda: body_mesh(name, spec, surfaces)),
            degree=spec.degree,
            true_surfaces=true_surfaces(spec.geometry, spec.placement),
            field=field,
        )
    elif mesh is not None:
        from iga_cea import NurbsSpace
        from meshes.nurbs_shapes import nurbs_shape

        breaks = breaks_of(spec.geometry, mesh.elements, mesh.through)
        patches, faces = nurbs_shape(spec.geometry, breaks, spec.placement)
        continuity = mesh.continuity
        space = NurbsSpace(patches, faces, mesh.degree, continuity=continuity, field=field)
    else:
        raise InputError(f"{field}.mesh.iga", None, "needed for 'iga'")
    applied = [each.applied for each in loads]
    return Body(
        name,
        space,
        spec.material,
        supports=spec.supports,
        springs=spec.springs,
        pressures=[each for each in applied if isinstance(each, Pressure)],
        forces=[each for each in applied if isinstance(each, Force)],
    )


def used_surfaces(scene: Scene, body: str) -> list[str]:
    """Return the surfaces of a body that supports, springs, loads and contacts use."""
    spec = scene.bodies[body]
    loads = [load.applied for load in scene.loads if load.on == body]
    acting: tuple[Any, ...] = (*spec.supports, *spec.springs, *loads)
    used = [each.surface for each in acting if each.surface is not None]
    for contact in scene.contacts.values():
        used += [surface for name, surface in contact.sides if name == body]
    return list(dict.fromkeys(used))


def body_mesh(body: str, spec: BodySpec, surfaces: Iterable[str]) -> Mesh:
    """Return the mesh of a body of Lagrange elements, with ``surfaces`` from a mesh file."""
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


def check_free(scene: Scene, bodies: Mapping[str, Body]) -> None:
    """Refuse modes of a scene, or modal damping of a body, without a free dof; collective."""
    if scene.analysis.kind == "static":
        return
    free = {name: int(body.expansion.getSize()[1]) for name, body in bodies.items()}
    allowed = "supports that leave a degree of freedom of the mesh free: they hold all of them"
    for name, spec in scene.bodies.items():
        modal = spec.damping is not None and spec.damping.modal is not None
        moves = free[name] > 0 or (any(free.values()) and not modal)
        held = [support.surface for support in spec.supports]
        require(moves, f"bodies.{name}.supports", held, allowed)


def build_contacts(scene: Scene, bodies: Mapping[str, Body], timer: StageTimer) -> list[Contact]:
    """Return the half passes of a scene, with points located on the opposite sides."""
    with timer("search"):
        return [
            half
            for name, spec in scene.contacts.items()
            for half in half_passes(name, spec, bodies)
        ]


def half_passes(name: str, spec: ContactSpec, bodies: Mapping[str, Body]) -> list[Contact]:
    """Return the half pass of a contact with points on side a; in a full pass, also on side b."""
    passes = (False, True) if spec.full_pass else (False,)
    return [_half_pass(name, spec, bodies, reverse=each) for each in passes]


def _half_pass(
    name: str, spec: ContactSpec, bodies: Mapping[str, Body], *, reverse: bool
) -> Contact:
    """Return a half pass with stiffness and friction; P is distributed uniformly over its points.

    Points of the larger side of a full pass that have no opposite point are dropped.
    """
    (body_a, on_a), (body_b, on_b) = reversed(spec.sides) if reverse else spec.sides
    a, b = bodies[body_a].surfaces[on_a], bodies[body_b].surfaces[on_b]
    rule = spec.formulation.points_on(a, b, spec.reach or default_reach(a, b))
    missed = 1.0 if spec.full_pass and a.area > b.area else spec.max_missed
    field = f"contacts.{name}"
    interface = pair(a, b, rule, field=field, reach=spec.reach, max_missed=missed)
    points, share = interface.points, 0.5 if spec.full_pass else 1.0
    with below(field):
        law: NormalLaw
        if spec.law is not None:
            law = replace(spec.law, c=share * spec.law.c)
        else:
            p = spec.p if spec.p is not None else (spec.P or 0.0) / float(points.weight.sum())
            law = LinearLaw(share * _values("p", p, points.x))
        sliding = None
        if spec.sliding is not None:
            given = {n: value for n, value in asdict(spec.sliding).items() if value is not None}
            sliding = Sliding(**{n: _values(f"sliding.{n}", v, points.x) for n, v in given.items()})
        friction = None
        if spec.friction_direction_on_a is not None:
            mu = _values("mu", spec.mu, points.x)
            # rounding errors of an expression that vanishes
            negligible = np.abs(mu) < _ROUNDING * np.abs(mu).max(initial=0.0)
            mu = np.where(negligible, 0.0, mu)
            friction = Friction(mu, spec.friction_direction_on_a, reverse)
        return Contact(
            name=name + B_ON_A if reverse else name,
            pair=name,
            a=body_a,
            b=body_b,
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
    """Prefix the fields of input errors with the path of their section."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}.{error.field}", error.value, error.allowed) from None


def _values(name: str, field: float | str, x: Floats) -> Floats:
    try:
        return evaluate(field, x)
    except InputError as error:
        raise InputError(name, error.value, error.allowed) from None


def build_system(
    scene: Scene,
    bodies: Mapping[str, Body],
    contacts: Sequence[Contact],
    timer: StageTimer,
    *,
    leave_out: bool = True,
) -> CoupledSystem:
    """Assemble the coupled system: mass only for eigenvalues, loads only if they have an effect."""
    static = scene.analysis.kind == "static"
    motions = {}
    for name, body in scene.bodies.items():
        damping = body.damping
        if not static or body.rotation is not None:  # damping has no static effect without rotation
            rayleigh, modal = (damping.rayleigh(), damping.modal) if damping else (None, None)
            motions[name] = Motion(rayleigh, body.rotation, modal)
    with timer("assembly"):
        check_free(scene, bodies)
        return couple(
            bodies,
            contacts,
            with_mass=not static,
            with_load=static or scene.slides_steadily,
            leave_out=leave_out,
            motions=motions,
        )
