"""What is wrong with a scene: pydantic's faults in the user's words, and checks between fields."""

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from pydantic import ValidationError

from cea.arrays import of_size_one
from cea.checks import check_density, check_surface
from cea.contact.formulations import Formulation, registered
from cea.errors import InputError
from cea.fields import Expression
from cea.rotation import Rotation
from meshes.breaks import check_breaks
from scenes.limits import MAX_ELEMENTS, limit_checks
from scenes.spec.body import Backend, BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.load import LoadSpec
from scenes.spec.mesh import FeMesh, IgaMesh
from scenes.spec.scene import SceneSpec


def faults_told_by(error: ValidationError) -> list[InputError]:
    """Faults that pydantic found, each under its own field."""
    faults: dict[str, InputError] = {}
    for detail in error.errors(include_url=False):
        cause = detail.get("ctx", {}).get("error")
        place = _place(detail["loc"])
        allowed = detail["msg"][0].lower() + detail["msg"][1:]
        if detail["type"] in ("unexpected_keyword_argument", "extra_forbidden"):
            allowed = "no such field; remove it or mend its name"
        if isinstance(cause, InputError):
            place, value, allowed = (
                f"{place}.{cause.field.split('.')[-1]}",
                cause.value,
                cause.allowed,
            )
        elif isinstance(cause, ValueError):
            value, allowed = detail["input"], str(cause)
        else:
            value = detail["input"] if detail["type"] != "missing" else None
        if place in faults:  # one of several forms the field may take
            allowed = f"{faults[place].allowed}, or {allowed}"
        faults[place] = InputError(place, value, allowed)
    return list(faults.values())


_CHOICES = (
    *("geometry", "formulation", "analysis", "friction_direction_on_a", "p", "mu"),
    *("pressure", "speed", "mu_slope"),
)
"""Fields of several forms: pydantic adds the name of the form to the path behind them."""
_INNER_CHOICES = (("crowned", "base"),)
"""The same inside of a form, of which its name is told too, as a body may be named as the field."""


def _place(path: Sequence[str | int]) -> str:
    """Path of a field as the user wrote it."""
    before = ["", "", *path]
    written = [
        part
        for part, behind in zip(path, pairwise(before), strict=False)
        if behind[1] not in _CHOICES and behind not in _INNER_CHOICES
    ]
    return ".".join(map(str, written)) or "scene"


def cross_checks(scene: SceneSpec) -> Iterable[InputError]:
    """Faults between fields, each of which is right by itself."""
    yield from limit_checks(scene)
    if not scene.bodies:
        yield InputError("bodies", {}, "at least one body")
    for name, body in scene.bodies.items():
        yield from _body_checks(f"bodies.{name}", body)
        if scene.analysis.kind == "cea":
            yield from _fault(check_density, body.material, f"bodies.{name}.material")
    known = sorted(f"{n}.{s}" for n, body in scene.bodies.items() for s in body.geometry.surfaces)
    for name, contact in scene.contacts.items():
        for side in ("a", "b"):
            yield from _known(f"contacts.{name}.{side}", getattr(contact, side), known)
        if contact.a.split(".")[0] == contact.b.split(".")[0]:
            yield InputError(f"contacts.{name}.b", contact.b, f"another body than {contact.a}")
        yield from _pressure_checks(f"contacts.{name}.sliding.pressure", contact)
        yield from _formulation_checks(scene, name, contact)
        yield from _dimension_checks(scene, f"contacts.{name}", contact)
    if scene.analysis.kind == "static" and scene.output.pictures:
        yield InputError("output.pictures", scene.output.pictures, "0 in a static analysis")
    for i, load in enumerate(scene.loads):
        yield from _load_checks(scene, f"loads.{i}", load, known)


def _load_checks(
    scene: SceneSpec, place: str, load: LoadSpec, known: Sequence[str]
) -> Iterable[InputError]:
    """Loads on what is not there, and forces of another dimension."""
    if load.surface is not None:
        yield from _known(f"{place}.surface", load.surface, known)
    elif load.body not in scene.bodies:
        yield InputError(f"{place}.body", load.body, f"one of {', '.join(scene.bodies)}")
    if load.on not in scene.bodies:
        return
    dim = len(scene.bodies[load.on].geometry.directions)
    for name, value in (("force", load.force), ("body_force", load.body_force)):
        if value is not None and len(value) != dim:
            yield InputError(f"{place}.{name}", value, f"{dim} components")


_THIN = 1e-12
"""Smallest range of a coordinate, relative to the coordinate."""

_CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}


def _mesh_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Meshes that do not suit the dimension of the shape."""
    directions = body.geometry.directions
    dim, names = len(directions), ", ".join(directions)
    if body.geometry.shape == "patches" and body.backend == "fe":
        yield InputError(f"{place}.backend", "fe", "'iga' for a geometry of patches")
    fe, iga = body.mesh.fe, body.mesh.iga
    if fe is not None and fe.cell not in _CELLS[dim]:
        yield InputError(f"{place}.mesh.fe.cell", fe.cell, " or ".join(_CELLS[dim]))
    numbers: dict[str, tuple[int, ...] | None] = {}
    if fe is not None:
        numbers |= {"fe.elements": fe.elements}
    if iga is not None:
        numbers |= {"iga.degree": iga.degree, "iga.elements": iga.elements}
        numbers |= {"iga.continuity": iga.continuity}
    for name, values in numbers.items():
        if values is not None and len(values) != dim:
            yield InputError(f"{place}.mesh.{name}", values, f"one number for each of {names}")
    for backend, mesh in (("fe", fe), ("iga", iga)):
        if mesh is not None and mesh.elements is not None and len(mesh.elements) == dim:
            yield from _elements_checks(f"{place}.mesh.{backend}", body, mesh)


def _elements_checks(place: str, body: BodySpec, mesh: FeMesh | IgaMesh) -> Iterable[InputError]:
    """Elements that are too few for their shape, or too many for any machine."""
    elements = mesh.elements or ()
    if not all(1 <= count <= MAX_ELEMENTS for count in elements):
        yield InputError(f"{place}.elements", elements, f"1 to {MAX_ELEMENTS} along each direction")
    else:
        yield from _fault(check_breaks, body.geometry, elements, mesh.through, place)


def _space_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Places, supports and springs that do not suit the dimension of the shape."""
    dim = len(body.geometry.directions)
    yield from _fault(body.placement.check, dim, f"{place}.placement")
    for i, support in enumerate(body.supports):
        yield from _fault(support.support().check, dim, f"{place}.supports.{i}")
    if body.rotation is not None:
        yield from _rotation_checks(place, body, body.rotation)
    for i, spring in enumerate(body.springs):
        if len(spring.stiffness) != dim:
            allowed = f"{dim} values (N/m^3), one for each component"
            yield InputError(f"{place}.springs.{i}.stiffness", spring.stiffness, allowed)
    for name, (low, high) in zip(body.geometry.directions, body.geometry.extent, strict=True):
        if not high - low > _THIN * max(abs(low), abs(high)):
            allowed = "a range that is not lost in the rounding of its ends"
            yield InputError(f"{place}.geometry", f"{name} from {low} to {high}", allowed)


_AXISYMMETRIC = ("annulus", "hub", "disc", "ring")
"""Shapes that a rotation about their own axis leaves as they are."""
_ASIDE = 1e-9
"""Distance of an axis from that of a shape, relative to its radius, and sine of their angle."""


def _rotation_checks(place: str, body: BodySpec, rotation: Rotation) -> Iterable[InputError]:
    """Rotations that do not leave the body as it is."""
    shape, dim = body.geometry.shape, len(body.geometry.directions)
    yield from _fault(rotation.check, dim, f"{place}.rotation")
    if shape not in _AXISYMMETRIC:
        yield InputError(f"{place}.geometry.shape", shape, f"{', '.join(_AXISYMMETRIC)} to rotate")
        return
    axis = body.placement.rotation[:, 2]
    given = of_size_one(rotation.axis)
    given /= np.linalg.norm(given)
    if np.linalg.norm(np.cross(axis, given)) > _ASIDE:
        yield InputError(f"{place}.rotation.axis", rotation.axis, f"along {axis.tolist()}")
    arm = np.subtract(rotation.origin, body.placement.translation)
    radius = body.geometry.extent[0][1]
    if np.linalg.norm(np.cross(axis, arm)) > _ASIDE * radius:
        allowed = f"a point of the axis of the body, as {list(body.placement.translation)}"
        yield InputError(f"{place}.rotation.origin", rotation.origin, allowed)


def _body_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    yield from _mesh_checks(place, body)
    yield from _space_checks(place, body)
    if getattr(body.mesh, body.backend) is None:
        yield InputError(f"{place}.mesh.{body.backend}", None, f"needed for {body.backend!r}")
    for kind in ("supports", "springs"):
        for i, item in enumerate(getattr(body, kind)):
            yield from _known(f"{place}.{kind}.{i}.surface", item.surface, body.geometry.surfaces)


def _pressure_checks(place: str, contact: ContactSpec) -> Iterable[InputError]:
    """Contacts that slide at an unknown pressure, or at one beside that of the loads."""
    if contact.sliding is None:
        return
    pressure = contact.sliding.pressure
    if pressure is None and contact.c_n is None:
        yield InputError(place, None, "the contact pressure (N/m^2), or c_n, which makes it")
    elif pressure is not None and contact.c_n is not None:
        yield InputError(place, pressure, "left out where c_n is given: the loads make it")


_ABSCISSAE: dict[Backend, tuple[str, ...]] = {"fe": ("nodes",), "iga": ("greville", "botella")}
"""Kinds of abscissae that surfaces of each backend have."""


def _formulation_checks(scene: SceneSpec, name: str, contact: ContactSpec) -> Iterable[InputError]:
    """Abscissae that the side they are asked of does not have."""
    for side in ("a", "b") if contact.full_pass else ("a",):
        body = scene.bodies.get(getattr(contact, side).split(".")[0])
        if body is not None and not suits(contact.formulation, body.backend):
            allowed = ", ".join(m for m, kind in registered().items() if suits(kind, body.backend))
            yield InputError(
                f"contacts.{name}.formulation.method",
                contact.formulation.method,
                f"one of {allowed} where side {side} has backend {body.backend!r}",
            )


def _dimension_checks(scene: SceneSpec, place: str, contact: ContactSpec) -> Iterable[InputError]:
    """Sides of different dimensions, and directions and fields of another one."""
    dims = {
        len(scene.bodies[name].geometry.directions)
        for name in (contact.a.split(".")[0], contact.b.split(".")[0])
        if name in scene.bodies
    }
    if len(dims) > 1:
        yield InputError(f"{place}.b", contact.b, f"a body of the same dimension as {contact.a}")
    for dim in dims if len(dims) == 1 else ():
        if contact.friction_direction_on_a is not None:
            direction = f"{place}.friction_direction_on_a"
            yield from _fault(contact.friction_direction_on_a.check, dim, direction)
        sliding = contact.sliding.fields if contact.sliding is not None else {}
        if dim == 2 and sliding.get("speed") is not None:
            allowed = "left out in the plane, where the direction of sliding cannot turn"
            yield InputError(f"{place}.sliding.speed", sliding["speed"], allowed)
        fields = {"p": contact.p, "mu": contact.mu}
        fields |= {f"sliding.{name}": value for name, value in sliding.items()}
        for name, value in fields.items():
            if isinstance(value, str):
                yield from _fault(Expression(value).check, f"{place}.{name}", dim)


def suits(formulation: Formulation | type[Formulation], backend: Backend) -> bool:
    """Whether surfaces of a backend have the abscissae that a formulation needs."""
    return formulation.abscissae is None or formulation.abscissae in _ABSCISSAE[backend]


def _known(place: str, name: str, known: Iterable[str]) -> Iterable[InputError]:
    yield from _fault(check_surface, name, known, place)


def _fault(check: Callable[..., Any], *arguments: Any) -> Iterable[InputError]:
    """Fault that a shared check finds, collected with the others rather than raised."""
    try:
        check(*arguments)
    except InputError as error:
        yield error
