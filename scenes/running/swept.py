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
_IN_FULL = "so each value is a run of its own: cea sweep ... --full, along this field alone"
_NO_PARAMETER = {
    "bodies.*.material.nu": f"the stiffness is not proportional to it, {_IN_FULL}",
    "bodies.*.material": "E and rho are those of a material",
    "bodies.*.damping.alpha": "damping = { alpha = 0.0 } in the scene makes it a parameter",
    "bodies.*.damping.beta": "damping = { beta = 0.0 } in the scene makes it a parameter",
    "bodies.*.damping": "alpha and beta, or the ratios of modal damping, are those of damping",
    "bodies.*.rotation.rate": "a rotation in the scene, of rate 0 too, makes it a parameter",
    "bodies.*.supports": f"other displacements are unknowns, {_IN_FULL}",
    "bodies.*.springs": f"a spring is part of the stiffness that E does not scale, {_IN_FULL}",
    "bodies": f"it makes another mesh, {_IN_FULL}",
    "contacts.*.mu": "friction_direction_on_a in the scene makes it a parameter of a contact",
    "contacts.*.P": "the law of a contact with c_n makes it in its state of steady sliding",
    "contacts.*.p": "P of the contact is proportional to it",
    "contacts.*.sliding": "it is one of a contact that has it in the scene",
    "contacts": f"it makes other matrices of the contact, {_IN_FULL}",
    "loads": f"loads move the state of steady sliding alone, {_IN_FULL}",
    "analysis": "it changes no eigenvalue: --set sets it",
}
"""What to do instead, by the beginnings of paths that are no parameters; the first one counts."""


def means_several(name: str) -> bool:
    """Whether a name is short for paths of parameters, or has asterisks in it."""
    return name in _SHORT or "*" in name


def is_one_of(name: str, pattern: str) -> bool:
    """Whether a path is one that another means, in which asterisks stand for names."""
    return name.count(".") == pattern.count(".") and _begins_like(name, pattern)


def _begins_like(name: str, pattern: str) -> bool:
    parts, meant = name.split("."), pattern.split(".")
    return len(parts) >= len(meant) and all(
        one in (part, "*") for part, one in zip(parts, meant, strict=False)
    )


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
        instead = (do for kind, do in _NO_PARAMETER.items() if _begins_like(pattern, kind))
        there = f"one of {', '.join(sorted(pencil.parameters)) or 'none'}"
        raise InputError("parameter", pattern, "; ".join([*[*instead][:1], there]))
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
