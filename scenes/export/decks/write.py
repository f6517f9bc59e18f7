"""Export of scenes as decks of CalculiX: a model file, and a file of steps that includes it.

Scenes that a deck cannot represent are refused before meshing.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

from cea.errors import InputError, require
from cea.files import check_writable, write_whole
from cea.petsc import MPI
from cea.ranks import made_on_first
from cea.surface import Surface
from cea.timing import StageTimer
from meshes.mesh_file import MeshFile
from scenes.building.build import build_bodies, used_surfaces
from scenes.export.decks.calculix import deck_lines
from scenes.export.decks.model import ELEMENTS, deck_bodies, model_lines, set_name
from scenes.spec.body import BodySpec, file_name
from scenes.spec.contact import ContactSpec
from scenes.spec.problems import SceneError
from scenes.spec.reading import Scene

_LABEL = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,29}")
"""Names that CalculiX accepts unchanged; it ignores case."""
_LABELS = "a letter, then at most 29 letters, digits, _ or -,"
_UNWRITTEN = "left out, because it cannot be exported,"

_Claim = tuple[str, Any, Any, str]
"""A field, its value, whether it is wrong, and what is allowed."""


def write_deck(scene: Scene, folder: Path, modes: int = 20) -> list[Path]:
    """Write a scene as a deck of CalculiX that requests a number of modes; collective.

    Rank 0 writes ``NAME_model.inp`` and ``NAME_calculix.inp``, which includes it, where NAME is the
    name of the scene with characters other than letters, digits, _ and - replaced by _. Raises a
    SceneError that names all fields that a deck cannot represent.
    """
    require(modes >= 1, "modes", modes, "1 or more")
    faults = [
        InputError(field, value, f"{allowed} for a deck")
        for field, value, wrong, allowed in _claims(scene)
        if wrong
    ]
    if faults:
        raise SceneError(faults)
    name = file_name(scene.name)
    files = [folder / f"{name}_{kind}.inp" for kind in ("model", "calculix")]
    for file in files:
        made_on_first(MPI.COMM_WORLD, partial(check_writable, file, "out"))
    built = build_bodies(scene, StageTimer())
    surfaces = {
        f"{body}.{surface}": built[body].surfaces[surface]
        for contact in scene.contacts.values()
        for body, surface in contact.sides
    }
    made_on_first(MPI.COMM_WORLD, lambda: _write(scene, surfaces, files, modes))
    return files


def _write(scene: Scene, surfaces: Mapping[str, Surface], files: list[Path], modes: int) -> None:
    model, deck = files
    bodies = deck_bodies(scene)
    steps = deck_lines(scene, bodies, surfaces, model.name, modes)
    for file, lines in ((deck, steps), (model, model_lines(scene, bodies))):
        # CalculiX reads ASCII reliably, but not other encodings.
        write_whole("".join(f"{line}\n" for line in lines).encode("ascii", "replace"), file)


def _claims(scene: Scene) -> Iterator[_Claim]:
    """Yield the requirements of a deck on a scene."""
    kind = scene.analysis.kind
    yield "analysis.kind", kind, kind != "cea", "'cea'"
    count = f"{len(scene.loads)} of them"
    yield "loads", count, scene.loads, "none, since without c_n they do not affect eigenvalues,"
    for name, body in scene.bodies.items():
        yield f"bodies.{name}", name, not _LABEL.fullmatch(name), _LABELS
        yield from _claims_on_body(f"bodies.{name}", body)
    for name, contact in scene.contacts.items():
        yield f"contacts.{name}", name, not _LABEL.fullmatch(name), _LABELS
        yield from _claims_on_contact(f"contacts.{name}", contact)
    # Names of sets must differ after conversion to lower case and of dots to hyphens.
    sets = {f"bodies.{name}": name.lower() for name in scene.bodies}
    for name, body in scene.bodies.items():
        from_file = isinstance(body.geometry, MeshFile)
        surfaces = used_surfaces(scene, name) if from_file else body.geometry.surfaces
        for each in surfaces:
            sets[f"bodies.{name}.geometry.{each}"] = set_name(f"{name}.{each}").lower()
    uses = Counter(sets.values())
    for place, name in sets.items():
        yield place, name, uses[name] > 1, "a name that gives its set a unique name"


def _claims_on_body(field: str, body: BodySpec) -> Iterator[_Claim]:
    allowed = "'fe', Lagrange elements (--backend fe),"
    yield f"{field}.backend", body.backend, body.backend != "fe", allowed
    fe = body.mesh.fe if body.backend == "fe" else None
    if fe is not None:  # elements of mesh files are checked when the file is read
        known = (fe.cell, fe.degree) in ELEMENTS
        allowed = (
            "1, or 2 with cell = 'tetrahedron', geometry_degree = 1, for 3D bodies, since there is "
            f"no element with the nodes of a {fe.cell} of degree {fe.degree},"
        )
        yield f"{field}.mesh.fe.degree", fe.degree, not known, allowed
        curved = known and (fe.geometry_degree or fe.degree) not in {1, fe.degree}
        place = f"{field}.mesh.fe.geometry_degree"
        yield place, fe.geometry_degree, curved, f"1 or {fe.degree}"
    axes = body.material.axes
    by_text = axes is not None and not (axes.uniform or axes.cylindrical_about)
    yield f"{field}.material.axes", axes, by_text, "numbers, or cylindrical"
    for name in ("springs", "damping", "rotation"):
        yield f"{field}.{name}", getattr(body, name), getattr(body, name), _UNWRITTEN
    for i, support in enumerate(body.supports):
        place, components = f"{field}.supports.{i}", list(support.components)
        yield f"{place}.components", components, set(components) - set("xyz"), "x, y or z"
        allowed = "left out, since supports are fixed at zero,"
        yield f"{place}.value", support.value, support.value is not None, allowed


def _claims_on_contact(field: str, contact: ContactSpec) -> Iterator[_Claim]:
    for name, allowed in (
        ("c_n", "left out, with P or p given instead,"),
        ("full_pass", "false, since points lie on side a, the slave,"),
        ("sliding", _UNWRITTEN),
    ):
        yield f"{field}.{name}", getattr(contact, name), getattr(contact, name), allowed
    for name in ("P", "p"):
        value = getattr(contact, name)
        wrong = value is not None and not (isinstance(value, float | int) and isfinite(value))
        yield f"{field}.{name}", value, wrong, "a finite number"
    yield f"{field}.mu", contact.mu, not isinstance(contact.mu, float | int), "a number"
    method, bonded = contact.formulation.method, contact.formulation.coupling == "bonded"
    yield f"{field}.formulation.method", method, bonded, "one that is not bonded"
