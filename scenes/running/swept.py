"""Parameters of a pencil and fields of its scene: names that mean them, changes that they make.

A field is a parameter of an assembled pencil where that has one by its path, with the value that
the scene had: all of it that the field reaches is then a coefficient. What else differs between two
scenes makes another pencil, but for what each solve and each record takes from its own scene.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from math import isclose, isfinite
from typing import Any

from cea.eigen.pencil import Pencil
from cea.errors import InputError
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
"""Short names of what contacts and bodies have."""


def means_several(name: str) -> bool:
    """Whether a name is short for paths of parameters, or has asterisks in it."""
    return name in _SHORT or "*" in name


def is_one_of(name: str, pattern: str) -> bool:
    """Whether a path is one that another means, in which asterisks stand for names."""
    parts, meant = name.split("."), pattern.split(".")
    same = (one in (part, "*") for part, one in zip(parts, meant, strict=False))
    return len(parts) == len(meant) and all(same)


def parameters_meant(pencil: Pencil, name: str, bonded: Iterable[str] = ()) -> list[str]:
    """Parameters of a pencil that a name means."""
    pattern = _SHORT.get(name, name)
    aside = {f"contacts.{each}." for each in bonded} if name in _SHORT else set()
    found = [
        each
        for each in pencil.parameters
        if is_one_of(each, pattern) and not any(each.startswith(start) for start in aside)
    ]
    if not found:
        allowed = (
            f"one of {', '.join(sorted(pencil.parameters)) or 'none'}; other fields make other "
            "pieces: cea sweep ... --full solves each value in full"
        )
        raise InputError("parameter", pattern, allowed)
    return found


def stiffnesses_meant(contacts: Mapping[str, ContactSpec], name: str) -> dict[str, float]:
    """The p of each contact whose p a name means: P is proportional to it."""
    pattern, found = _SHORT.get(name, name), {}
    for each, spec in contacts.items():
        path = f"contacts.{each}.p"
        if not is_one_of(path, pattern):
            continue
        if name in _SHORT and spec.formulation.coupling == "bonded":
            continue
        if not isinstance(spec.p, float):
            allowed = f"a number in the scene; contacts.{each}.P scales the field"
            if spec.p is None:
                given = "P" if spec.P is not None else "c_n"
                allowed = f"given in the scene, which gives contacts.{each}.{given}"
            raise InputError(path, spec.p, allowed)
        if not isfinite(spec.p):
            raise InputError(path, spec.p, f"finite in the scene, or contacts.{each}.P")
        found[each] = spec.p
    return found


def in_saddle_form(scene: Scene) -> Scene:
    """The scene with the forces of contacts at points as unknowns: none is lost to stiffness."""
    contacts = scene.contacts.items()
    pointwise = [name for name, each in contacts if each.formulation.coupling == "pointwise"]
    return scene.change({f"contacts.{name}.form": "saddle" for name in pointwise})


def no_two_alike(groups: Sequence[Iterable[str]], names: Sequence[str]) -> None:
    """Refuse axes that mean one parameter twice."""
    seen: dict[str, str] = {}
    for group, name in zip(groups, names, strict=True):
        for each in group:
            if each in seen:
                raise InputError("axis", name, f"other parameters than {seen[each]}: {each}")
            seen[each] = name


_OF_EACH_SOLVE = (
    *("analysis.max_frequency", "analysis.min_growth", "analysis.growth_threshold"),
    *("name", "description", "output.pictures", "output.paraview"),
)
"""Fields that no piece of a pencil is made of; one that is missing here costs an assembly."""
_ROUNDING = 1e-12
"""Of a parameter that is a sum over points, relative to the field it stands for."""


def parameters_changed(pencil: Pencil, old: Scene, new: Scene) -> dict[str, float] | None:
    """Parameters of a pencil at which it is that of another scene."""
    values: dict[str, float] = {}
    old, new = _in_factors(old, old.bodies), _in_factors(new, new.bodies)
    for path, before, after in differences(old, new):
        if path in _OF_EACH_SOLVE:
            continue
        if not (_stands_for(pencil, path, before) and isinstance(after, float)):
            return None
        values[path] = after
    return values


def _stands_for(pencil: Pencil, path: str, value: Any) -> bool:
    """Whether a pencil has a parameter for a field, which has this value."""
    parameter = pencil.parameters.get(path)
    if parameter is None or not isinstance(value, float):
        return False
    return isclose(parameter.value, value, rel_tol=_ROUNDING)


def _in_factors(scene: Scene, names: Iterable[str]) -> Scene:
    """A scene in which the Rayleigh damping of some bodies is given by factors."""
    bodies = dict(scene.bodies)
    for name in names:
        body = bodies[name]
        if body.damping is not None:
            bodies[name] = replace(body, damping=body.damping.in_factors)
    return replace(scene, bodies=bodies)


def at_parameters(scene: Scene, pencil: Pencil, values: Mapping[str, float]) -> Scene:
    """The scene whose pencil is that of another one at some parameters."""
    scene = _in_factors(scene, {path.split(".")[1] for path in values if ".damping." in path})
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
    """A field where its parameter has another value than its own."""
    if own == 0 or isinstance(field, float):
        return value
    factor = value / own
    return (
        [factor * each for each in field] if isinstance(field, tuple) else f"{factor!r}*({field})"
    )


def _field(scene: Scene, path: str) -> Any:
    """Value of a field of a body or a contact."""
    section, name, *fields = path.split(".")
    found: Any = getattr(scene, section)[name]
    for field in fields:
        found = getattr(found, field)
    return found


def differences(old: Any, new: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Fields in which two sections of scenes differ: path, old and new value of each.

    Tables and lists are compared entry by entry where they have the same entries, else as a whole.
    """
    if old == new:
        return
    before, after = _entries(old), _entries(new)
    if type(old) is type(new) and before and before.keys() == after.keys():
        for name, value in before.items():
            yield from differences(value, after[name], f"{path}.{name}" if path else name)
    else:
        yield path, old, new


def _entries(section: Any) -> Mapping[str, Any]:
    """Entries of a section of a scene by name; none of a value."""
    if is_dataclass(section) and not isinstance(section, type):
        return {field.name: getattr(section, field.name) for field in fields(section)}
    if isinstance(section, Mapping):
        return section
    if isinstance(section, Sequence) and not isinstance(section, str):
        return {str(i): value for i, value in enumerate(section)}
    return {}
