"""Relation of the parameters of a pencil to the fields of its scene.

A field of the scene is a parameter of the assembled pencil if the pencil has one with the path of
the field and its value: the pencil then depends on the field through coefficients alone.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import isclose, isfinite
from typing import Any

from cea.eigen.pencil import Pencil
from cea.errors import InputError, require
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

_SHORT = {
    "mu": "contacts.*.mu",
    "P": "contacts.*.P",
    "p": "contacts.*.p",
    "E": "bodies.*.material.E",
    "rho": "bodies.*.material.rho",
    "alpha": "bodies.*.damping.alpha",
    "beta": "bodies.*.damping.beta",
    "Omega": "bodies.*.rotation.rate",
}
"""Short names of fields of all contacts or all bodies."""
_OF_EACH_SOLVE = (
    "analysis.max_frequency",
    "analysis.min_growth",
    "analysis.growth_threshold",
    "name",
    "description",
    "output.pictures",
    "output.paraview",
)
"""Fields that do not affect the pencil; a change of any other field needs a new assembly."""
_ROUNDING = 1e-12
"""Relative tolerance between a parameter, which may be a sum over points, and its field."""


def means_several(name: str) -> bool:
    """Whether a name is a short name or contains asterisks."""
    return name in _SHORT or "*" in name


def _meant(name: str, path: str, bonded: Iterable[str]) -> bool:
    """Whether a name matches a path; asterisks match names, short names skip bonded contacts."""
    pattern = re.escape(_SHORT.get(name, name)).replace(r"\*", r"[^.]+")
    aside = name in _SHORT and any(path.startswith(f"contacts.{each}.") for each in bonded)
    return re.fullmatch(pattern, path) is not None and not aside


def parameters_meant(pencil: Pencil, name: str, bonded: Iterable[str] = ()) -> list[str]:
    """Return the parameters of a pencil that a name matches."""
    found = [each for each in pencil.parameters if _meant(name, each, bonded)]
    there = ", ".join(sorted(pencil.parameters)) or "none"
    allowed = f"one of {there}; for others cea sweep ... --full solves each value in full"
    require(bool(found), "parameter", _SHORT.get(name, name), allowed)
    return found


def stiffnesses_meant(contacts: Mapping[str, ContactSpec], name: str) -> dict[str, float]:
    """Return p of each contact whose field p a name matches; P is proportional to it."""
    bonded = [each for each, spec in contacts.items() if spec.formulation.coupling == "bonded"]
    found = {}
    for each, spec in contacts.items():
        path = f"contacts.{each}.p"
        if _meant(name, path, bonded):
            if not isinstance(spec.p, float) or not isfinite(spec.p):
                allowed = f"a finite number in the scene, or contacts.{each}.P or c_n instead"
                raise InputError(path, spec.p, allowed)
            found[each] = spec.p
    return found


def in_saddle_form(scene: Scene) -> Scene:
    """Return the scene with pointwise contacts in saddle form, which loses no digits."""
    contacts = scene.contacts.items()
    pointwise = [name for name, each in contacts if each.formulation.coupling == "pointwise"]
    return scene.change({f"contacts.{name}.form": "saddle" for name in pointwise})


def no_two_alike(groups: Sequence[Iterable[str]], names: Sequence[str]) -> None:
    """Raise an InputError if two axes match the same parameter."""
    seen: dict[str, int] = {}
    for number, (group, name) in enumerate(zip(groups, names, strict=True)):
        for each in group:
            first = seen.setdefault(each, number)
            allowed = f"other parameters than {names[first]}: {each}"
            require(first == number, "axis", name, allowed)


def parameters_changed(
    pencil: Pencil, old: Scene, new: Scene, paths: Iterable[str]
) -> dict[str, float] | None:
    """Return the parameters at which the pencil is that of the changed scene; None if none are."""
    values: dict[str, float] = {}
    for path in paths:
        parameter = pencil.parameters.get(path)
        if parameter is not None:
            before, after = _field(old, path), _field(new, path)
            numbers = isinstance(before, float) and isinstance(after, float)
            if not (numbers and isclose(parameter.value, before, rel_tol=_ROUNDING)):
                return None
            values[path] = after
        elif path not in _OF_EACH_SOLVE:
            return None
    return values


def at_parameters(scene: Scene, pencil: Pencil, values: Mapping[str, float]) -> Scene:
    """Return the scene whose pencil equals that of ``scene`` at the given parameters."""
    bodies = dict(scene.bodies)
    for name in {path.split(".")[1] for path in values if ".damping." in path}:
        damping = bodies[name].damping
        bodies[name] = replace(bodies[name], damping=damping and damping.in_factors)
    scene = replace(scene, bodies=bodies)
    changes: dict[str, Any] = {}
    for name, value in values.items():
        own, field, of_p = pencil.parameter(name).value, _field(scene, name), f"{name[:-1]}p"
        if field is not None:
            changes[name] = _scaled(field, value, own)
        elif isinstance(p := _field(scene, of_p), float):
            changes |= {name: value, of_p: None}
        else:
            changes[of_p] = _scaled(p, value, own)
    return scene.change(changes)


def _scaled(field: Any, value: float, own: float) -> Any:
    """Return a field with its parameter changed from ``own`` to ``value``."""
    if own == 0 or isinstance(field, float):
        return value
    factor = value / own
    if isinstance(field, tuple):
        return [factor * each for each in field]
    return f"{factor!r}*({field})"


def _field(scene: Scene, path: str) -> Any:
    """Return the value of a field of a body or a contact; None if its section is missing."""
    section, name, *fields = path.split(".")
    found: Any = getattr(scene, section)[name]
    for field in fields:
        found = getattr(found, field, None)
    return found
