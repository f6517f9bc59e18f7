"""Scenes whose parameters are swept: which parameters of a pencil a name means."""

from collections.abc import Iterable, Sequence

from cea.eigen.pencil import Pencil
from cea.errors import InputError

_SHORT = {
    "mu": "contacts.*.mu",
    "P": "contacts.*.P",
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
    return len(parts) == len(meant) and all(
        one in (part, "*") for part, one in zip(parts, meant, strict=True)
    )


def parameters_meant(pencil: Pencil, name: str, bonded: Iterable[str] = ()) -> list[str]:
    """Parameters of a pencil that a name means.

    Parameters
    ----------
    pencil
        The pencil.
    name
        A path, with asterisks for any name; or ``mu`` and ``P`` of every contact that can slide,
        ``E`` and ``rho`` of every body, ``alpha``, ``beta`` and ``Omega`` of those that have such
        damping or rotate.
    bonded
        Contacts that cannot slide.

    Raises
    ------
    InputError
        When there is none.
    """
    pattern = _SHORT.get(name, name)
    aside = {f"contacts.{each}." for each in bonded} if name in _SHORT else set()
    found = [
        each
        for each in pencil.parameters
        if is_one_of(each, pattern) and not any(each.startswith(start) for start in aside)
    ]
    return found or [pencil.parameter(pattern).name]


def no_two_alike(groups: Sequence[Sequence[str]], names: Sequence[str]) -> None:
    """Refuse axes that mean one parameter twice."""
    seen: dict[str, str] = {}
    for group, name in zip(groups, names, strict=True):
        for each in group:
            if each in seen:
                raise InputError("axis", name, f"other parameters than {seen[each]}: {each}")
            seen[each] = name
