"""Which changes of a scene are changes of parameters of its pencil, and which leave its points."""

from collections.abc import Sequence
from dataclasses import fields, replace

from cea.damping import ModalDamping
from scenes.read import Scene
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec


def parameters_changed(old: Scene, new: Scene) -> dict[str, float] | None:
    """Parameters of the pencil that make the one scene the other; None where others differ."""
    if old.bodies.keys() != new.bodies.keys() or old.contacts.keys() != new.contacts.keys():
        return None
    values: dict[str, float] = {}
    for name, body in old.bodies.items():
        found = _of_body(body, new.bodies[name])
        if found is None:
            return None
        values |= {f"bodies.{name}.{key}": value for key, value in found.items()}
    for name, contact in old.contacts.items():
        found = _of_contact(contact, new.contacts[name])
        if found is None:
            return None
        values |= {f"contacts.{name}.{key}": value for key, value in found.items()}
    return values


def _of_body(old: BodySpec, new: BodySpec) -> dict[str, float] | None:
    """Changes of E, rho, damping and rate of rotation."""
    before, after = _numbers_of(old), _numbers_of(new)
    if before.keys() != after.keys() or _without_numbers(old) != _without_numbers(new):
        return None
    return {key: value for key, value in after.items() if value != before[key]}


def _numbers_of(body: BodySpec) -> dict[str, float]:
    """Parameters that a body brings to a pencil, by their paths below its own."""
    numbers = {"material.E": body.material.E}
    if body.material.rho is not None:
        numbers["material.rho"] = body.material.rho
    if body.damping is not None and (damping := body.damping.rayleigh()) is not None:
        numbers |= {"damping.alpha": damping.alpha, "damping.beta": damping.beta}
    if (modal := _modal(body)) is not None and modal.ratio is not None:
        numbers["damping.modal.ratio"] = modal.ratio
    if body.rotation is not None:
        numbers["rotation.rate"] = body.rotation.rate
    return numbers


def _without_numbers(body: BodySpec) -> tuple[BodySpec, ModalDamping | None]:
    """What the matrices of a body depend on beside its parameters."""
    modal, material = _modal(body), body.material
    moving = modal is not None and (modal.end is not None or bool(body.springs))
    if not moving:  # modes that are damped are others where the material is
        material = replace(material, E=1.0, rho=None)
    if modal is not None and modal.ratio is not None:
        modal = replace(modal, ratio=0.0)
    rotation = replace(body.rotation, rate=0.0) if body.rotation is not None else None
    return replace(body, material=material, damping=None, rotation=rotation), modal


def _modal(body: BodySpec) -> ModalDamping | None:
    return body.damping.modal if body.damping is not None else None


def _of_contact(old: ContactSpec, new: ContactSpec) -> dict[str, float] | None:
    """Changes of P, mu and of how it slides; expressions have factors for parameters."""
    if not _alike(old, new, ("P", "mu", "sliding")) or (old.sliding is None) != (
        new.sliding is None
    ):
        return None
    fields = [(key, getattr(old, key), getattr(new, key)) for key in ("P", "mu")]
    if old.sliding is not None and new.sliding is not None:
        after = new.sliding.fields
        fields += [
            (f"sliding.{key}", value, after[key]) for key, value in old.sliding.fields.items()
        ]
    found = {}
    for key, before, value in fields:
        if before != value:
            if not (isinstance(before, float) and isinstance(value, float)):
                return None
            if key.startswith("sliding.") and not before:
                return None  # zero everywhere is no parameter
            found[key] = value
    return found


_LAW = (*("P", "p", "c_n", "m_n", "added_gap", "mu", "friction_direction_on_a", "form", "sliding"),)
"""Fields of a contact on which its points do not depend."""


def same_points(old: Scene, new: Scene) -> bool:
    """Whether the contact points of two scenes with the same bodies are the same."""
    return old.contacts.keys() == new.contacts.keys() and all(
        _alike(contact, new.contacts[name], _LAW) for name, contact in old.contacts.items()
    )


def _alike(old: ContactSpec, new: ContactSpec, but: Sequence[str]) -> bool:
    """Whether all fields but some are equal."""
    return all(
        getattr(old, field.name) == getattr(new, field.name)
        for field in fields(ContactSpec)
        if field.name not in but
    )
