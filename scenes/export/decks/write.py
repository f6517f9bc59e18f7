"""Scenes written as decks: a model, and the steps of each program, which include it.

Scenes that a deck cannot hold are refused before a mesh is made.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from math import isfinite
from pathlib import Path

from cea.errors import InputError
from cea.files import check_writable, write_whole
from cea.petsc import MPI
from cea.ranks import made_on_first
from meshes.mesh_file import MeshFile
from scenes.building.body_meshes import used_surfaces
from scenes.export.decks.abaqus import abaqus_text
from scenes.export.decks.bodies import DeckBody, deck_bodies, set_name
from scenes.export.decks.calculix import calculix_text
from scenes.export.decks.elements import ELEMENTS
from scenes.export.decks.model import model_text
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.mesh import FeMesh
from scenes.spec.names import file_name
from scenes.spec.problems import SceneError
from scenes.spec.reading import Scene

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


MAX_MODES = 10_000
"""Modes that a deck may ask for."""
PROGRAMS = {"calculix": calculix_text, "abaqus": abaqus_text}
"""What writes the deck of each program."""


def write_deck(scene: Scene, folder: Path, modes: int = 20) -> list[Path]:
    """Write a scene as decks of CalculiX and Abaqus; collective, rank 0 writes.

    Parameters
    ----------
    scene
        A scene of Lagrange bodies whose elements these programs have.
    folder
        Folder of ``NAME_model.inp``, ``NAME_calculix.inp``, ``NAME_abaqus.inp``, NAME that of the
        scene, in which signs but letters, digits, _ and - become _.
    modes
        Number of modes to ask for.

    Returns
    -------
    list of Path
        The files, the model first.

    Raises
    ------
    SceneError, InputError
        When a deck cannot hold the scene, naming the field.
    """
    if not 1 <= modes <= MAX_MODES:
        raise InputError("modes", modes, f"1 to {MAX_MODES}")
    check_exportable(scene)
    name = file_name(scene.name)
    files = [folder / f"{name}_{kind}.inp" for kind in ("model", *PROGRAMS)]
    made_on_first(MPI.COMM_WORLD, lambda: _write(scene, files, modes))
    return files


def _write(scene: Scene, files: list[Path], modes: int) -> None:
    for file in files:
        check_writable(file, "out")
    bodies = deck_bodies(scene)
    model, *decks = files
    texts = [model_text(scene, bodies)]
    for program, write in PROGRAMS.items():
        texts.append(write(scene, bodies, model.name, modes, _told(scene, bodies, program)))
    for file, text in zip([model, *decks], texts, strict=True):
        write_whole(text.encode("ascii", "replace"), file)  # all that both programs surely read


def _told(scene: Scene, bodies: dict[str, DeckBody], program: str) -> list[str]:
    """What heads a deck."""
    lines = [f"{scene.name}, for {program}. Units are those of the scene."]
    lines += [
        f"{name}: {len(body.mesh.points)} nodes, {len(body.mesh.cells)} {body.element_type}"
        for name, body in bodies.items()
    ]
    for name, contact in scene.contacts.items():
        lines.append(
            f"Contact {name}: slave {contact.a}, master {contact.b}, penalty on the surface of the "
            f"slave in place of the formulation {contact.formulation.method}."
        )
    if program == "abaqus":
        lines.append("Written after the manual of Abaqus/Standard, and not run with it.")
    return lines
