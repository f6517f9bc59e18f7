"""Scenes as plain data, and plain data as scenes."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields, is_dataclass
from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cea.errors import InputError
from scenes.spec.problems import SceneError, problems

_LATER = {
    "StaticAnalysis": {"load_steps"},
    "ComplexEigenvalueAnalysis": {"min_growth", "load_steps", "geometric_stiffness"},
    "BodySpec": {"damping", "rotation"},
    "ContactSpec": {"c_n", "m_n", "added_gap", "sliding"},
    "LoadSpec": {"force", "body", "body_force"},
    "MatrixScene": {"symmetric"},
    "FeMesh": {"edges", "layers"},
    "MeshSpec": {"degree"},
    "DampingSpec": {"modal"},
    "Scene": {"units"},
    "SceneSpec": {"units"},
    "SupportSpec": {"value"},
    "Patches": {"merge_nodes"},
    "NurbsFile": {"merge_nodes"},
}
"""Fields that came later than stored numbers, which are found by fingerprints of their scenes: they
do not stand there where they have their defaults."""


def as_data(section: Any) -> Any:
    """A scene or a section of one as nested dictionaries, as ``dataclasses.asdict`` gives it."""
    if is_dataclass(section):
        later = _LATER.get(type(section).__name__, set())
        return {
            field.name: as_data(value)
            for field in fields(section)
            if (value := getattr(section, field.name)) != field.default or field.name not in later
        }
    if isinstance(section, Mapping):
        return {name: as_data(part) for name, part in section.items()}
    if isinstance(section, list | tuple):
        return type(section)(as_data(part) for part in section)
    return section


def checked[T](kind: TypeAdapter[T], data: Mapping[str, Any]) -> T:
    """Nested dictionaries as what they should be."""
    try:
        content = json.dumps(data, default=_plain, ensure_ascii=False).encode()
    except (TypeError, ValueError, RecursionError) as error:
        if isinstance(error, SceneError):
            raise
        if isinstance(error, UnicodeEncodeError):
            raise SceneError(list(_half_characters(plain_data(data)))) from error
        allowed = f"text, numbers, lists, and tables of them by name, not too deep: {error}"
        raise SceneError([InputError("scene", "...", allowed)]) from error
    try:
        return kind.validate_json(content)
    except ValidationError as error:
        raise SceneError(problems(error, json.loads(content), _schema(kind))) from error


def _half_characters(data: Any, path: str = "") -> Iterator[InputError]:
    """A refusal of every text that holds half of a character, which no file can."""
    if isinstance(data, str) and not data.isascii() and any("\ud800" <= c < "\ue000" for c in data):
        yield InputError(path or "scene", data, "text of whole characters")
    elif isinstance(data, Mapping):
        for name, part in data.items():
            yield from _half_characters(name, path)
            yield from _half_characters(part, f"{path}.{name}".removeprefix("."))
    elif isinstance(data, list | tuple):
        for number, part in enumerate(data):
            yield from _half_characters(part, f"{path}[{number}]")


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
