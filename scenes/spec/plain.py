"""Scenes as plain data in which fields that say nothing are left out.

Stored numbers are found by fingerprints of their scenes: a field that came later than they did must
not stand there where it has its default.
"""

import json
from collections.abc import Mapping
from dataclasses import MISSING, Field, asdict, fields, is_dataclass
from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cea.errors import InputError
from scenes.spec.problems import SceneError, problems


def as_data(section: Any) -> Any:
    """A scene or a section of one as nested dictionaries, as :func:`dataclasses.asdict` gives it.

    Parameters
    ----------
    section
        Dataclasses, and tables and lists of them. Fields that a class names in ``left_out`` are
        left out where they have their defaults.
    """
    if is_dataclass(section):
        return {
            field.name: as_data(value)
            for field in fields(section)
            if not _is_left_out(section, field, value := getattr(section, field.name))
        }
    if isinstance(section, Mapping):
        return {name: as_data(part) for name, part in section.items()}
    if isinstance(section, list | tuple):
        return type(section)(as_data(part) for part in section)
    return section


def _is_left_out(section: Any, field: Field[Any], value: Any) -> bool:
    """Whether a field may be left out, and has the value that it then has."""
    if field.name not in getattr(section, "left_out", ()):
        return False
    default = field.default if field.default is not MISSING else None
    return bool(value == default)


_DEEPEST = 100
"""Tables and lists inside each other."""
_WHOLE = 10**400
"""Whole numbers are smaller; beyond some thousand digits they cannot even be written."""


def checked[T](kind: TypeAdapter[T], data: Mapping[str, Any]) -> T:
    """Nested dictionaries as what they should be.

    Raises
    ------
    SceneError
        With one line for each fault.
    """
    try:
        text = json.dumps(data, default=_plain, ensure_ascii=False)
        content = text.encode()
    except (SceneError, TypeError, ValueError, RecursionError) as error:
        raise SceneError([_unreadable(data)]) from error
    try:
        return kind.validate_json(content)
    except ValidationError as error:
        plain = json.loads(content)
        raise SceneError(problems(error, plain, _schema(kind))) from error


@cache
def _schema(kind: TypeAdapter[Any]) -> dict[str, Any]:
    """The fields of a kind of scene."""
    return kind.json_schema()


def plain_data(value: Any) -> Any:
    """A scene or a part of one as nested dictionaries, lists and numbers, which it is read from."""
    return json.loads(json.dumps(value, default=_plain))


def _plain(value: Any) -> Any:
    """What JSON has no form for: sections of scenes, and numbers and arrays of numpy."""
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise SceneError([InputError("value", value, "plain data, or a section of a scene")])


def _unreadable(data: Any) -> InputError:
    """The first value that is none of tables, lists, text and numbers."""
    allowed = "text, numbers, lists, and tables of them by name"
    level: list[tuple[str, Any]] = [("scene", data)]
    for _ in range(_DEEPEST):
        inner: list[tuple[str, Any]] = []
        for place, value in level:
            dot = "" if place == "scene" else f"{place}."
            if isinstance(value, Mapping):
                if not all(_is_text(name) for name in value):
                    return InputError(place, list(value), f"{allowed}; names are text")
                inner += [(f"{dot}{name}", part) for name, part in value.items()]
            elif isinstance(value, list | tuple):
                inner += [(f"{dot}{i}", part) for i, part in enumerate(value)]
            elif not (value is None or _is_text(value) or _is_plain_number(value)):
                return InputError(place, value, allowed)
        level = inner
    return InputError(level[0][0] if level else "scene", "...", f"nested less than {_DEEPEST} deep")


def _is_text(value: Any) -> bool:
    """Whether a value is text that a file can hold."""
    try:
        return isinstance(value, str) and bool(value.encode() or True)
    except UnicodeEncodeError:
        return False


def _is_plain_number(value: Any) -> bool:
    return isinstance(value, bool | float) or (isinstance(value, int) and abs(value) < _WHOLE)
