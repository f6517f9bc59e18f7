"""What a deck has no words for: scenes are refused before a mesh is made."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from math import isfinite

from cea.errors import InputError
from meshes.mesh_file import MeshFile
from scenes.body_meshes import used_surfaces
from scenes.deck.bodies import set_name
from scenes.deck.elements import ELEMENTS
from scenes.read import Scene
from scenes.scene_error import SceneError
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.mesh import FeMesh

_LABEL = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,29}")
"""Names that both programs take as they are; they do not tell capitals from small letters."""


def check_exportable(scene: Scene) -> None:
    """Refuse a scene that a deck cannot hold."""
    faults = list(_faults(scene))
    if faults:
        raise SceneError(faults)


def _faults(scene: Scene) -> Iterator[InputError]:
    if scene.analysis.kind != "cea":
        yield InputError("analysis.kind", scene.analysis.kind, "'cea' for a deck")
    if scene.loads:
        field, allowed = "loads", "none for a deck: without c_n they move no eigenvalue"
        yield InputError(field, f"{len(scene.loads)} of them", allowed)
    for name, body in scene.bodies.items():
        yield from _name_faults(f"bodies.{name}", name)
        yield from _body_faults(f"bodies.{name}", body)
    for name, contact in scene.contacts.items():
        yield from _name_faults(f"contacts.{name}", name)
        yield from _contact_faults(f"contacts.{name}", contact)
        dim = len(scene.bodies[contact.a.split(".")[0]].geometry.directions)
        if dim == 2:
            allowed = "none in the plane for a deck; bodies in space touch"
            yield InputError(f"contacts.{name}", f"{contact.a}, {contact.b}", allowed)
    yield from _repeated_names(scene)


def _name_faults(field: str, name: str) -> Iterator[InputError]:
    if not _LABEL.fullmatch(name):
        allowed = "a letter, then at most 29 letters, digits, _ or -, for a deck"
        yield InputError(field, name, allowed)


def _repeated_names(scene: Scene) -> Iterator[InputError]:
    """Sets whose names become one: capitals count as small letters, and a dot as a hyphen."""
    places = [f"bodies.{name}" for name in scene.bodies]
    names = [name.lower() for name in scene.bodies]
    for name, body in scene.bodies.items():
        from_file = isinstance(body.geometry, MeshFile)
        surfaces = used_surfaces(scene, name) if from_file else body.geometry.surfaces
        places += [f"bodies.{name}.geometry.{each}" for each in surfaces]
        names += [set_name(f"{name}.{each}").lower() for each in surfaces]
    count = Counter(names)
    for place, name in zip(places, names, strict=True):
        if count[name] > 1:
            yield InputError(place, name, "a name for its set that no other has, for a deck")


def _body_faults(field: str, body: BodySpec) -> Iterable[InputError]:
    if body.backend != "fe":
        allowed = "'fe': a deck holds Lagrange elements, no NURBS (--backend fe)"
        yield InputError(f"{field}.backend", body.backend, allowed)
        return
    if body.mesh.fe is not None:
        yield from _element_faults(f"{field}.mesh.fe", body, body.mesh.fe)
    for name in ("springs", "damping", "rotation"):
        if value := getattr(body, name):
            yield InputError(f"{field}.{name}", value, "left out for a deck: it is not written")
    for i, support in enumerate(body.supports):
        if "normal" in support.components:
            allowed = "x, y, z, or radial, circumferential, axial, for a deck"
            yield InputError(f"{field}.supports.{i}.components", ["normal"], allowed)
        if support.value is not None:
            allowed = "left out for a deck: supports hold at zero"
            yield InputError(f"{field}.supports.{i}.value", support.value, allowed)


def _element_faults(field: str, body: BodySpec, fe: FeMesh) -> Iterator[InputError]:
    """Elements that no deck has; those of mesh files show when the file is read."""
    if (fe.cell, fe.degree) not in ELEMENTS:
        wanted = "tetrahedron" if len(body.geometry.directions) == 3 else "triangle"
        allowed = (
            f"1 for a deck, or 2 with cell = {wanted!r}, geometry_degree = 1: no element there has "
            f"the nodes of a {fe.cell} of degree {fe.degree}"
        )
        yield InputError(f"{field}.degree", fe.degree, allowed)
    elif (fe.geometry_degree or fe.degree) not in {1, fe.degree}:
        allowed = f"1 or {fe.degree} for a deck"
        yield InputError(f"{field}.geometry_degree", fe.geometry_degree, allowed)


def _contact_faults(field: str, contact: ContactSpec) -> Iterator[InputError]:
    if contact.c_n is not None:
        yield InputError(f"{field}.c_n", contact.c_n, "left out for a deck: P or p is given")
    for name in ("P", "p"):
        value = getattr(contact, name)
        if value is not None and not (isinstance(value, float | int) and isfinite(value)):
            yield InputError(f"{field}.{name}", value, "a finite number for a deck")
    if not isinstance(contact.mu, float | int):
        yield InputError(f"{field}.mu", contact.mu, "a number for a deck")
    if contact.full_pass:
        allowed = "false for a deck: points lie on side a, the slave"
        yield InputError(f"{field}.full_pass", contact.full_pass, allowed)
    if contact.sliding is not None:
        allowed = "left out for a deck: it is not written"
        yield InputError(f"{field}.sliding", contact.sliding, allowed)
    if contact.formulation.coupling == "bonded":
        allowed = "one that is not bonded for a deck"
        yield InputError(f"{field}.formulation.method", contact.formulation.method, allowed)
