"""Plain data of scenes: nested dictionaries, lists, text and numbers, made what they should be."""

import json
from collections.abc import Mapping
from dataclasses import asdict, is_dataclass
from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cea.errors import InputError
from scenes.faults import faults_told_by
from scenes.field_tree import FieldTree
from scenes.scene_error import SceneError

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
        raise SceneError(faults_told_by(error, _tree(kind))) from error


@cache
def _tree(kind: TypeAdapter[Any]) -> FieldTree:
    """The fields of a kind of scene."""
    return FieldTree(kind.json_schema())


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
