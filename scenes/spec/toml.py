"""Scenes as the text of scene files."""

import json
from collections.abc import Mapping
from math import inf, isinf
from typing import Any

from scenes.spec.plain import as_data, plain_data
from scenes.spec.reading import Scene

_BARE = set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")
_TABLES = ("bodies", "contacts")
"""Sections whose entries are tables of their own."""


def scene_text(scene: Scene) -> str:
    """A scene as TOML: read again, it is the same scene."""
    data = _given(plain_data(as_data(scene)))
    lines = _fields({name: value for name, value in data.items() if name not in _TABLES})
    for name in _TABLES:
        for entry, table in data.get(name, {}).items():
            lines += ["", f"[{name}.{_key(entry)}]", *_fields(table)]
    return "\n".join(lines) + "\n"


def _fields(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(name)} = {_value(value)}" for name, value in table.items()]


def _given(value: Any) -> Any:
    """Plain data without what is None, which TOML has no word for, and without what is empty."""
    if isinstance(value, Mapping):
        parts = {name: _given(part) for name, part in value.items()}
        return {name: part for name, part in parts.items() if part not in (None, [], {})}
    if isinstance(value, list | tuple):
        return [_given(part) for part in value]
    return value


def _key(name: str) -> str:
    return name if name and set(name) <= _BARE else json.dumps(name, ensure_ascii=False)


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and isinf(value):
        return "inf" if value == inf else "-inf"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
