"""Export of scenes as decks of CalculiX: a model file, and a file of steps that includes it.

Scenes that a deck cannot represent are refused before meshing.

In a scene the contacts are closed by assumption. A deck has to close them: the sides overlap by a
closure that is so small that nothing deforms; all pressures are the contact stiffness times it.

Friction on side a acts against the velocity of a relative to b: if side a is at rest, side b moves
in the direction of friction on a.

CalculiX does not compute steady sliding itself. It is imposed by a static step with all nodes
fixed, so that all contacts keep the given overlap and nothing deforms; the frequency step then
releases all nodes except the supports.

The static step displaces the moving bodies as rigid bodies, far enough for every point to slip.
Friction then equals the limit up to rounding, and the frequency step would treat many points as
sticking: for the disc and pad it then finds no instability. The static step therefore has twice the
friction; with that of the scene all points are then beyond the limit. Normal to the slip direction
CalculiX adds the stick stiffness, which the scene does not have; it is chosen small.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from cea.contact.pressure_and_friction import AlongVector, Circumferential
from cea.errors import InputError, require
from cea.files import check_writable, write_whole
from cea.petsc import MPI
from cea.ranks import made_on_first
from cea.surface import Surface
from cea.timing import StageTimer
from meshes.mesh_file import MeshFile
from scenes.building.build import build_bodies, used_surfaces
from scenes.export.deck_model import (
    ELEMENTS,
    DeckBody,
    boundary_lines,
    comments,
    deck_bodies,
    keyword,
    model_lines,
    numbers,
    set_name,
    table,
)
from scenes.spec.body import BodySpec, file_name
from scenes.spec.contact import ContactSpec
from scenes.spec.problems import Faults
from scenes.spec.reading import Scene

_LABEL = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,29}")
"""Names that CalculiX accepts unchanged; it ignores case."""
_LABELS = "a letter, then at most 29 letters, digits, _ or -,"
_UNWRITTEN = "left out, because it cannot be exported,"

_Claim = tuple[str, Any, Any, str]
"""A field, its value, whether it is wrong, and what is allowed."""

Motion = tuple[AlongVector | Circumferential, float]
"""Field of a rigid motion, and its least speed at the nodes of the sides a that it slides on."""

_CLOSURE = 1e-12
"""Closure, relative to the size of the bodies: slip is then small and rounding of coordinates is
smaller."""
_STICK = 1e-5
"""Stick stiffness, relative to the contact stiffness."""
_MORE_FRICTION = 2.0
"""Friction coefficient of the static step, relative to that of the scene."""
_BEYOND = 2.0
"""Imposed slip, relative to that at which a point begins to slip."""
_TANGENT = 1e-6
"""Relative normal component of a velocity below which it is treated as tangential."""


def write_deck(scene: Scene, folder: Path, modes: int = 20) -> list[Path]:
    """Write a scene as a deck of CalculiX that requests a number of modes; collective.

    Rank 0 writes ``NAME_model.inp`` and ``NAME_calculix.inp``, which includes it, where NAME is the
    name of the scene with characters other than letters, digits, _ and - replaced by _. Raises a
    SceneError that names all fields that a deck cannot represent.
    """
    require(modes >= 1, "modes", modes, "1 or more")
    faults = Faults()
    for field, value, wrong, allowed in _claims(scene):
        faults.require(not wrong, field, value, f"{allowed} for a deck")
    faults.refuse()
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


@dataclass(frozen=True)
class DeckContact:
    """A contact pair of a deck."""

    interaction: str  # name of its surface interaction
    slave: str  # surface of side a, which has the integration points
    master: str
    stiffness: float  # p (N/m^3), uniform
    mu: float


def deck_lines(
    scene: Scene,
    bodies: Mapping[str, DeckBody],
    surfaces: Mapping[str, Surface],
    model: str,
    modes: int,
) -> Iterator[str]:
    """Yield the lines of the deck of a validated scene, which includes the file ``model``.

    ``surfaces`` are given by "body.surface"; ``modes`` is the number of modes to compute.
    """
    contacts = []
    for name, spec in scene.contacts.items():
        p = float(spec.p or 0.0) if spec.P is None else spec.P / surfaces[spec.a].area
        sides = set_name(spec.a), set_name(spec.b)
        contacts.append(DeckContact(f"{name}-interaction", *sides, p, float(spec.mu)))
    motions = _moving_bodies(scene.contacts, bodies, surfaces)
    points = np.concatenate([body.points for body in bodies.values()])
    closure = _CLOSURE * float(np.ptp(points, axis=0).max())
    yield from comments(_about(scene, bodies))
    yield f"*INCLUDE, INPUT={model}"
    yield from boundary_lines(bodies)
    yield from _contact_lines(contacts, closure)
    yield from _step_lines(bodies, contacts, motions, closure, modes)


def _about(scene: Scene, bodies: Mapping[str, DeckBody]) -> Iterator[str]:
    """Yield the comments at the head of a deck."""
    yield f"{scene.name}, for CalculiX. Units are those of the scene."
    for name, body in bodies.items():
        yield f"{name}: {len(body.points)} nodes, {len(body.elements)} {body.element_type}"
    for name, contact in scene.contacts.items():
        yield (
            f"Contact {name}: slave {contact.a}, master {contact.b}, penalty on the surface of the "
            f"slave instead of the formulation {contact.formulation.method}."
        )


def _contact_lines(contacts: list[DeckContact], closure: float) -> Iterator[str]:
    """Yield surface interactions with linear laws, and contact pairs with a closure (m)."""
    for each in contacts:
        yield keyword("SURFACE INTERACTION", NAME=each.interaction)
        yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
        yield numbers(each.stiffness)
        if each.mu:
            yield from ("*FRICTION", numbers(_MORE_FRICTION * each.mu, _STICK * each.stiffness))
        yield keyword("CONTACT PAIR", INTERACTION=each.interaction, TYPE="SURFACE TO SURFACE")
        yield f"{each.slave}, {each.master}"
        overlap = numbers(-closure)  # replaces the distances of the nodes
        yield keyword("CLEARANCE", MASTER=each.master, SLAVE=each.slave, VALUE=overlap)


def _moving_bodies(
    contacts: Mapping[str, ContactSpec],
    bodies: Mapping[str, DeckBody],
    surfaces: Mapping[str, Surface],
) -> dict[str, Motion]:
    """Return the motions of the moving bodies, by name; all others are at rest."""
    motions: dict[str, Motion] = {}
    sliding = {name: contact for name, contact in contacts.items() if contact.mu}
    resting = {contact.sides[0][0] for contact in sliding.values()}
    for name, contact in sliding.items():
        direction, field = contact.friction_direction_on_a, f"contacts.{name}"
        (owner, surface), (body, _) = contact.sides
        allowed = "a body that is side b of every contact with friction, or of none"
        require(body not in resting, f"{field}.b", contact.b, allowed)
        field = f"{field}.friction_direction_on_a"
        if not isinstance(direction, AlongVector | Circumferential):
            allowed = "a vector, or circumferential: that of a rigid motion"
            raise InputError(field, direction, allowed)
        before = motions.get(body)
        same = before is None or before[0] == direction
        require(same, field, direction, f"the same for all contacts of which {body} is side b")
        x = bodies[owner].points[bodies[owner].nodes_of(surface)]
        slowest = float(np.linalg.norm(direction.at(x), axis=1).min())
        motions[body] = direction, min(slowest, before[1] if before else slowest)
        for side in (contact.a, contact.b):
            points = surfaces[side].gauss_points(2)
            velocity = direction.at(points.x)
            across = np.abs(np.einsum("ij,ij->i", points.normal, velocity))
            tangential = bool((across <= _TANGENT * np.linalg.norm(velocity, axis=1)).all())
            allowed = f"tangential to {side} everywhere, so that the sides stay in contact"
            require(tangential, field, direction, allowed)
    return motions


def _step_lines(
    bodies: Mapping[str, DeckBody],
    contacts: list[DeckContact],
    motions: Mapping[str, Motion],
    closure: float,
    modes: int,
) -> Iterator[str]:
    """Yield a static step that closes and slides the contacts, and the frequency step."""
    if contacts:
        yield from comments(["Sides closed and sliding; nothing deforms."])
        yield from ("*STEP", "*STATIC, DIRECT", "1., 1.", "*BOUNDARY, OP=NEW")
        largest = max(each.mu for each in contacts) * closure
        slip = _BEYOND * _MORE_FRICTION * largest / _STICK
        for name, body in bodies.items():
            if name in motions:
                direction, slowest = motions[name]
                yield from _displacement_lines(body, slip / slowest * direction.at(body.points))
            else:
                yield f"{name}, 1, 3"
        for each in contacts:
            yield from (f"*CONTACT PRINT, MASTER={each.master}, SLAVE={each.slave}", "CF")
        yield "*END STEP"
        yield from comments(
            ["Modes about that state, with the supports and friction of the scene."]
        )
    yield "*STEP, PERTURBATION" if contacts else "*STEP"
    for each in contacts:
        if each.mu:
            yield keyword("CHANGE FRICTION", INTERACTION=each.interaction)
            yield from ("*FRICTION", numbers(each.mu, _STICK * each.stiffness))
    yield from ("*FREQUENCY, STORAGE=YES", str(modes))
    if contacts:
        yield from boundary_lines(bodies, OP="NEW")
    yield from ("*NODE FILE", "U", "*END STEP")


def _displacement_lines(body: DeckBody, vectors: np.ndarray) -> list[str]:
    """Return a line for each component of the displacements of all nodes, (n_nodes, 3)."""
    nodes = np.repeat(np.arange(len(vectors)) + body.first_node, 3)
    components = np.tile([1, 2, 3], len(vectors))
    values = vectors.ravel() + 0.0  # no negative zeros
    rows = np.column_stack([nodes, components, components, values])
    return table(rows, "%d,%d,%d,%.13E")
