"""Paths of fields, as ``loads[0].pressure``, and how plain data is changed along them."""

import re
import tomllib
from collections.abc import Iterable
from typing import Any

from cea.errors import InputError
from cea.suggestions import did_you_mean

Part = str | int

_STEP = re.compile(r"(?P<name>[^\[\]]+)(?P<numbers>(\[\d{1,9}\])*)")
"""A part of a path: a name, and numbers of entries in brackets behind it."""
_NUMBER = re.compile(r"\d{1,9}")
_BY_NAME = ("bodies", "contacts")
"""Tables whose entries are made whole: one field of what is not there is a name mistyped."""


def set_by_text(data: dict[str, Any], override: str) -> None:
    """Set a field of plain data by "path.to.field=value" with a TOML value.

    Raises
    ------
    InputError
        When there is no value, or no such place.
    """
    path, equals, text = override.partition("=")
    if not equals:
        raise InputError("--set", override, "path.to.field=value")
    set_at(data, path.strip(), _toml_value(text))


def set_at(data: dict[str, Any], path: str, value: Any) -> None:
    """Set a field of plain data through tables and lists; tables that are not there are made.

    Parameters
    ----------
    data
        Nested tables and lists.
    path
        Names with dots between; entries of lists by numbers from 0, ``loads[0].pressure`` or
        ``loads.0.pressure``.
    value
        The new value.

    Raises
    ------
    InputError
        Naming the place where the path ends too early, and what is there.
    """
    *parents, last = parts_of(path)
    table: Any = data
    for i, part in enumerate(parents):
        table = _inner(table, [*parents[:i], part], [*parents[i + 1 :], last])
    if isinstance(table, list):
        table[_index(table, last, [*parents, last])] = value
    else:
        table[_name(table, last, [*parents, last])] = value


def parts_of(path: str) -> list[Part]:
    """Names and numbers of a path.

    Raises
    ------
    InputError
        When it is none.
    """
    parts: list[Part] = []
    for step in path.split("."):
        match = _STEP.fullmatch(step.strip())
        if match is None:
            allowed = "names with dots between, and whole numbers in brackets: loads[0].pressure"
            raise InputError("--set", path, allowed)
        parts.append(match["name"])
        parts += [int(number) for number in _NUMBER.findall(match["numbers"])]
    return parts


def as_text(parts: Iterable[Part]) -> str:
    """A path with numbers in brackets."""
    text = ""
    for part in parts:
        dot = "." if text else ""
        text += f"[{part}]" if isinstance(part, int) else f"{dot}{part}"
    return text


def _inner(table: Any, place: list[Part], rest: list[Part]) -> Any:
    """The table or list at the next place of a path, made where a table may be missing."""
    part = place[-1]
    if isinstance(table, list):
        entry = table[_index(table, part, place)]
    else:
        name = _name(table, part, place)
        if table.get(name) is None:
            _check_new(table, place, rest)
            table[name] = {}
        entry = table[name]
    if not isinstance(entry, dict | list):
        wanted = as_text([*place, *rest])
        raise InputError(as_text(place), entry, f"a table or a list, for {wanted} to be set in it")
    return entry


def _check_new(table: dict[str, Any], place: list[Part], rest: list[Part]) -> None:
    """Refuse to make what nobody can have meant: a list, or a part of a body that is not there."""
    there = f"there are {', '.join(map(str, table)) or 'none'}{did_you_mean(place[-1], table)}"
    if isinstance(rest[0], int):
        raise InputError(as_text(place), None, f"a list that is there to be counted in; {there}")
    if len(place) == 2 and place[0] in _BY_NAME:
        raise InputError(as_text(place), None, f"one that is there, or given whole; {there}")


def _name(table: dict[str, Any], part: Part, place: list[Part]) -> str:
    if isinstance(part, int):
        allowed = f"a name: {as_text(place[:-1])} is a table of {', '.join(map(str, table))}"
        raise InputError(as_text(place), part, allowed)
    return part


def _index(entries: list[Any], part: Part, place: list[Part]) -> int:
    """Number of an entry that is there."""
    number = int(part) if isinstance(part, int) or _NUMBER.fullmatch(part) else -1
    if not 0 <= number < len(entries):
        there = f"from 0 to {len(entries) - 1}" if entries else "none: the list is empty"
        allowed = f"number of an entry of {as_text(place[:-1])}: {there}"
        raise InputError(as_text(place), part, allowed)
    return number


def _toml_value(text: str) -> Any:
    """Value of a field as TOML has it; what TOML has no value for is text."""
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if len(table) == 1 else text
