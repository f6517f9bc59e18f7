"""Every fault at once: what is wrong with the rest of a scene of which some sections are wrong."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from pydantic import ValidationError

from cea.errors import InputError

_KINDS = ("cea", "static")
_STAND_IN = {"static": {"kind": "static"}, "cea": {"kind": "cea", "max_frequency": 1.0}}
"""Analyses in the place of wrong ones."""


def faults_of_the_rest[T](
    data: dict[str, Any],
    error: ValidationError,
    read: Callable[[Any], T],
    checks: Callable[[T], Iterable[InputError]],
) -> list[InputError]:
    """Faults between the fields of those sections in which pydantic found none.

    A body whose geometry or mesh is wrong is left out, with the contacts and loads that name it.

    Parameters
    ----------
    data
        Plain data of a scene; tables in it are changed.
    error
        What pydantic found wrong with it.
    read
        Makes plain data a scene.
    checks
        Faults between the fields of a scene.

    Returns
    -------
    list of InputError
        Empty where too little is left to be checked.
    """
    places = [detail["loc"] for detail in error.errors(include_url=False)]
    wrong = {tuple(place[:2]) for place in places}
    if () in wrong or ("bodies",) in wrong:
        return []
    _leave_out_analysis(data, {place[0] for place in wrong})
    bodies = set(_leave_out_bodies(data["bodies"], places))
    for section, *names in wrong:
        if section == "contacts" and names:
            data[section].pop(names[0], None)
        elif section not in ("analysis", "bodies", "loads", "name") or (
            section == "loads" and not names
        ):
            data.pop(str(section), None)
    contacts = data.get("contacts", {})
    data["contacts"] = {n: c for n, c in contacts.items() if not _on(c, ("a", "b"), bodies)}
    loads = list(enumerate(data.get("loads", [])))
    kept = [
        (i, load)
        for i, load in loads
        if ("loads", i) not in wrong and not _on(load, ("surface", "body"), bodies)
    ]
    data["loads"] = [load for _, load in kept]
    data["name"] = "rest"
    if not data.get("bodies"):
        return []
    try:
        scene = read(data)
    except ValidationError:
        return []
    return list(_renumbered(checks(scene), [i for i, _ in kept]))


_HANDLED = ("analysis", "bodies", "loads", "name")
"""Sections of which parts are left out, or in whose place others stand."""
_MATERIAL = {"E": 1.0, "nu": 0.3, "rho": 1.0}
"""Material in the place of a wrong one."""
_NEEDED = ("backend", "geometry", "mesh")
"""Sections without which nothing of a body can be checked."""


def _leave_out_bodies(
    bodies: dict[str, Any], places: Sequence[tuple[str | int, ...]]
) -> Iterator[str]:
    """Leave out what is wrong of bodies; names of those that are left out whole."""
    for name in list(bodies):
        mine = {place[2:3] for place in places if place[:2] == ("bodies", name)}
        sections = {section for place in mine for section in place}
        if () in mine or sections & set(_NEEDED):
            del bodies[name]
            yield name
            continue
        for section in sections:
            bodies[name].pop(section, None)
        bodies[name].setdefault("material", _MATERIAL)


def _leave_out_analysis(data: dict[str, Any], wrong: set[Any]) -> None:
    """Put an analysis in the place of a wrong one; what depends on its kind goes where it is."""
    if "analysis" not in wrong:
        return
    analysis = data.get("analysis")
    kind = analysis.get("kind") if isinstance(analysis, dict) else None
    if kind not in _KINDS:
        kind = "static"
        data.pop("output", None)
    data["analysis"] = _STAND_IN[kind]


def _on(section: Any, names: Iterable[str], bodies: set[Any]) -> bool:
    """Whether a contact or load names a body that is left out."""
    places = [section.get(name) for name in names]
    return any(isinstance(place, str) and place.split(".")[0] in bodies for place in places)


def _renumbered(faults: Iterable[InputError], numbers: list[int]) -> Iterator[InputError]:
    """Faults of loads under the numbers that the loads have in the file."""
    for fault in faults:
        section, *rest = fault.field.split(".")
        if section == "loads" and rest and rest[0].isdecimal():
            field = ".".join(["loads", str(numbers[int(rest[0])]), *rest[1:]])
            yield InputError(field, fault.value, fault.allowed)
        else:
            yield fault
