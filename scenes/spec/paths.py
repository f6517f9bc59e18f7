"""Paths of fields, as ``loads[0].pressure``, and how plain data is changed along them."""

import re
import tomllib
from collections.abc import Iterable
from typing import Any

from cea.errors import InputError, did_you_mean

Part = str | int

_STEP = re.compile(r"(?P<name>[^\[\]]+)(?P<numbers>(\[\d{1,9}\])*)")
"""A part of a path: a name, and numbers of entries in brackets behind it."""
_NUMBER = re.compile(r"\d{1,9}")
_BY_NAME = ("bodies", "contacts")
"""Tables whose entries are made whole: one field of what is not there is a name mistyped."""


def set_by_text(data: dict[str, Any], override: str) -> None:
    """Set a field of plain data by "path.to.field=value" with a TOML value."""
    path, equals, text = override.partition("=")
    if not equals:
        raise InputError("--set", override, "path.to.field=value")
    value: Any = text  # what TOML has no value for is text
    try:
        table = tomllib.loads(f"value = {text}")
        value = table["value"] if len(table) == 1 else text
    except (ValueError, RecursionError):
        pass
    set_at(data, path.strip(), value)


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
    parts = parts_of(path)
    table: Any = data
    for i, part in enumerate(parts[:-1]):
        place, key = parts[: i + 1], _key(table, part, parts[: i + 1])
        if isinstance(table, dict) and table.get(key) is None:
            _check_new(table, place, parts[i + 1])
            table[key] = {}
        table = table[key]
        if not isinstance(table, dict | list):
            allowed = f"a table or a list, for {as_text(parts)} to be set in it"
            raise InputError(as_text(place), table, allowed)
    table[_key(table, parts[-1], parts)] = value


def parts_of(path: str) -> list[Part]:
    """Names and numbers of a path."""
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
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts)
    return text.removeprefix(".")


def _check_new(table: dict[str, Any], place: list[Part], below: Part) -> None:
    """Refuse to make what nobody can have meant: a list, or a part of a body that is not there."""
    there = f"there are {', '.join(map(str, table)) or 'none'}{did_you_mean(place[-1], table)}"
    if isinstance(below, int):
        raise InputError(as_text(place), None, f"a list that is there to be counted in; {there}")
    if len(place) == 2 and place[0] in _BY_NAME:
        raise InputError(as_text(place), None, f"one that is there, or given whole; {there}")


def _key(table: Any, part: Part, place: list[Part]) -> Any:
    """What an entry is found by: a name in a table, the number of one that is there in a list."""
    above = as_text(place[:-1])
    if isinstance(table, list):
        number = int(part) if isinstance(part, int) or _NUMBER.fullmatch(part) else -1
        if not 0 <= number < len(table):
            there = f"from 0 to {len(table) - 1}" if table else "none: the list is empty"
            raise InputError(as_text(place), part, f"number of an entry of {above}: {there}")
        return number
    if isinstance(part, int):
        allowed = f"a name: {above} is a table of {', '.join(map(str, table))}"
        raise InputError(as_text(place), part, allowed)
    return part
