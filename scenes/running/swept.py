"""Scenes whose parameters are swept: which parameters of a pencil a name means."""

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite

from cea.eigen.pencil import Pencil
from cea.errors import InputError
from scenes.spec.contact import ContactSpec

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


def no_two_alike(groups: Sequence[Iterable[str]], names: Sequence[str]) -> None:
    """Refuse axes that mean one parameter twice."""
    seen: dict[str, str] = {}
    for group, name in zip(groups, names, strict=True):
        for each in group:
            if each in seen:
                raise InputError("axis", name, f"other parameters than {seen[each]}: {each}")
            seen[each] = name
