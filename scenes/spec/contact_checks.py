"""What is wrong with contacts between their fields, and between contacts."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from cea.contact.formulations import Formulation, registered
from cea.errors import InputError
from cea.expressions import Expression
from cea.supports.boundary import check_surface
from scenes.spec.body import Backend
from scenes.spec.contact import ContactSpec
from scenes.spec.scene import SceneSpec

_ABSCISSAE: dict[Backend, tuple[str, ...]] = {"fe": ("nodes",), "iga": ("greville", "botella")}
"""Kinds of abscissae that surfaces of each backend have."""


def contact_checks(scene: SceneSpec, known: Sequence[str]) -> Iterator[InputError]:
    """Faults of contacts; surfaces are known as "body.surface"."""
    seen: dict[frozenset[str], str] = {}
    for name, contact in scene.contacts.items():
        place = f"contacts.{name}"
        yield from _side_checks(scene, place, contact, known)
        yield from _pressure_checks(f"{place}.sliding.pressure", contact)
        yield from _formulation_checks(scene, place, contact)
        yield from _dimension_checks(scene, place, contact)
        first = seen.setdefault(frozenset((contact.a, contact.b)), name)
        if first != name:
            allowed = f"other sides than contacts.{first}, which joins the same surfaces"
            yield InputError(f"{place}.a", f"{contact.a} on {contact.b}", allowed)


def _side_checks(
    scene: SceneSpec, place: str, contact: ContactSpec, known: Sequence[str]
) -> Iterator[InputError]:
    """Sides that are not there, on one body, or that cannot move."""
    for side in ("a", "b"):
        yield from unknown_surface(f"{place}.{side}", getattr(contact, side), known)
    if contact.a.split(".")[0] == contact.b.split(".")[0]:
        yield InputError(f"{place}.b", contact.b, f"another body than {contact.a}")
        return
    for side, where in (("a", contact.a), ("b", contact.b)):
        body, _, surface = where.partition(".")
        if where not in known or body not in scene.bodies:
            continue
        dim = len(scene.bodies[body].geometry.directions)
        for i, support in enumerate(scene.bodies[body].supports):
            count = len(set(support.components))
            if support.surface == surface and (count in (0, dim) or "normal" in support.components):
                held = "its normal displacement" if 0 < count < dim else "every displacement of it"
                allowed = f"a surface that may move: bodies.{body}.supports.{i} holds {held}"
                yield InputError(f"{place}.{side}", where, allowed)


def _pressure_checks(place: str, contact: ContactSpec) -> Iterable[InputError]:
    """Contacts that slide at an unknown pressure, or at one beside that of the loads."""
    if contact.sliding is None:
        return
    pressure = contact.sliding.pressure
    if pressure is None and contact.c_n is None:
        yield InputError(place, None, "the contact pressure (N/m^2), or c_n, which makes it")
    elif pressure is not None and contact.c_n is not None:
        yield InputError(place, pressure, "left out where c_n is given: the loads make it")


def _formulation_checks(scene: SceneSpec, place: str, contact: ContactSpec) -> Iterable[InputError]:
    """Abscissae that the side they are asked of does not have."""
    for side in ("a", "b") if contact.full_pass else ("a",):
        body = scene.bodies.get(getattr(contact, side).split(".")[0])
        if body is not None and not suits(contact.formulation, body.backend):
            allowed = ", ".join(m for m, kind in registered().items() if suits(kind, body.backend))
            allowed = f"one of {allowed} where side {side} has backend {body.backend!r}"
            yield InputError(f"{place}.formulation.method", contact.formulation.method, allowed)


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
            yield from fault_of(contact.friction_direction_on_a.check, dim, direction)
        sliding = contact.sliding.fields if contact.sliding is not None else {}
        if dim == 2 and sliding.get("speed") is not None:
            allowed = "left out in the plane, where the direction of sliding cannot turn"
            yield InputError(f"{place}.sliding.speed", sliding["speed"], allowed)
        fields = {"p": contact.p, "mu": contact.mu}
        fields |= {f"sliding.{name}": value for name, value in sliding.items()}
        for name, value in fields.items():
            if isinstance(value, str):
                yield from fault_of(Expression(value).check, f"{place}.{name}", dim)


def suits(formulation: Formulation | type[Formulation], backend: Backend) -> bool:
    """Whether surfaces of a backend have the abscissae that a formulation needs."""
    return formulation.abscissae is None or formulation.abscissae in _ABSCISSAE[backend]


def unknown_surface(place: str, name: str, known: Iterable[str]) -> Iterator[InputError]:
    """A surface that is not there."""
    yield from fault_of(check_surface, name, known, place)


def fault_of(check: Callable[..., Any], *arguments: Any) -> Iterator[InputError]:
    """Fault that a shared check finds, collected with the others rather than raised."""
    try:
        check(*arguments)
    except InputError as error:
        yield error
