"""Scenes as plain data: read from files, validated, changed by paths such as ``loads[0].force``."""

import json
import os
import re
import tomllib
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path, PurePath
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cea.contact.formulations import Formulation, registered
from cea.errors import did_you_mean
from cea.files import regular
from scenes.spec.problems import SceneError, problems, refuse

SCENES = Path(__file__).parents[1] / "catalogue"
"""Folder of the scenes that come with the project."""
OF_MATRICES = SCENES / "matrices"
"""Folder of the scenes of matrices that come with the project."""
_LATER = {
    "BodySpec": ("damping", "rotation"),
    "ComplexEigenvalueAnalysis": ("geometric_stiffness", "load_steps", "min_growth"),
    "ContactSpec": ("added_gap", "c_n", "m_n", "sliding"),
    "DampingSpec": ("modal",),
    "FeMesh": ("edges", "layers"),
    "LoadSpec": ("body", "body_force", "force"),
    "MatrixScene": ("symmetric",),
    "MeshSpec": ("degree",),
    "NurbsFile": ("merge_nodes",),
    "Patches": ("merge_nodes",),
    "Scene": ("units",),
    "StaticAnalysis": ("load_steps",),
    "Support": ("value",),
}
"""Fields added after results were stored. Stored results are found by a fingerprint of their scene,
so these fields are left out of the data where they have their defaults."""

_PATH = re.compile(r"([^.\[\]]+(\[\d+\])*)(\.[^.\[\]]+(\[\d+\])*)*")
"""A path: names separated by dots, each with indices in brackets."""
_BARE = re.compile(r"[A-Za-z0-9_-]+")
"""Bare keys of TOML, which need no quotes."""
_BY_NAME = ("bodies", "contacts")
"""Tables in which setting a field does not create a new entry: its name would be a misspelling."""


def checked[T: Hashable](kind: type[T], data: Mapping[str, Any]) -> T:
    """Validate nested dictionaries as a kind of scene; raise a SceneError with all faults."""
    content = _json(data)
    adapter = _adapter(kind, tuple(registered().values()))
    try:
        scene: T = adapter.validate_json(content)
    except ValidationError as error:
        raise SceneError(problems(error, json.loads(content), adapter.json_schema())) from error
    return scene


@cache
def _adapter(kind: type, _formulations: tuple[type[Formulation], ...]) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def plain_data(value: Any, place: str = "scene") -> Any:
    """Convert a scene or a part of one to nested dictionaries, lists, text and numbers.

    ``_LATER`` fields are left out at their defaults.
    """
    return json.loads(_json(value, place))


def _json(data: Any, place: str = "scene") -> bytes:
    """Serialise a scene or a part of one to JSON; raise a SceneError for other types."""
    try:
        return json.dumps(data, default=_plain, ensure_ascii=False).encode()
    except (TypeError, ValueError, RecursionError) as error:
        allowed = f"text, numbers, lists, and tables of them by name, not too deep: {error}"
        refuse(place, "...", allowed)


def _plain(value: Any) -> Any:
    """Convert types that JSON does not support: sections of scenes, paths, numpy arrays."""
    if is_dataclass(value) and not isinstance(value, type):
        later = _LATER.get(type(value).__name__, ())
        return {
            field.name: getattr(value, field.name)
            for field in fields(value)
            if field.name not in later or getattr(value, field.name) != field.default
        }
    if isinstance(value, PurePath):
        return str(value)
    if not hasattr(value, "tolist"):
        raise TypeError(f"{value!r} is not plain data, or a section of a scene")
    return value.tolist()


def leaves(data: Any, place: str = "scene") -> Iterator[tuple[str, Any]]:
    """Yield the values of nested tables and lists, each with its path."""
    if not isinstance(data, Mapping | list | tuple):
        yield place, data
        return
    for name, part in data.items() if isinstance(data, Mapping) else enumerate(data):
        yield from leaves(part, f"{place}.{name}".removeprefix("scene."))


def set_at(data: dict[str, Any], path: str, value: Any) -> None:
    """Set the field at a path; missing tables are created, missing entries of lists are not.

    Names in a path are separated by dots; entries of lists are numbered from 0:
    ``loads[0].pressure`` or ``loads.0.pressure``. Raises a SceneError with the part of the path
    that does not exist.
    """
    path = "".join(path.split())
    allowed = "names separated by dots, with indices in brackets: loads[0].pressure"
    if not _PATH.fullmatch(path):
        refuse("--set", path, allowed)
    parts, table = re.findall(r"[^.\[\]]+", path), data
    for i, part in enumerate(parts):
        place = ".".join(parts[: i + 1])
        below = parts[i + 1] if i + 1 < len(parts) else None
        key: Any = part
        if isinstance(table, list):
            there = f"from 0 to {len(table) - 1}" if table else "none: the list is empty"
            if part not in map(str, range(len(table))):
                refuse(place, part, f"index of an entry: {there}")
            key = int(part)
        elif table.get(part) is None and below is not None:
            _check_new(table, parts[: i + 1], below)
            table[part] = {}
        if below is None:
            table[key] = value
            return
        table = table[key]
        if not isinstance(table, dict | list):
            refuse(place, table, f"a table or a list, so that {'.'.join(parts)} can be set")


def _check_new(table: dict[str, Any], place: list[str], below: str) -> None:
    """Refuse to create a list, or a body or contact from a single field."""
    of_name = len(place) == 2 and place[0] in _BY_NAME
    there = f"{', '.join(table) or 'none'}{did_you_mean(place[-1], table)}"
    allowed = f"{'one' if of_name else 'a list'} that exists, or given whole; there are {there}"
    if of_name or below.isdecimal():
        refuse(".".join(place), None, allowed)


def tables_of(scene: str | Path, overrides: Iterable[str] = ()) -> dict[str, Any]:
    """Read a scene file as plain data and set the overrides; parameters as :func:`load_scene`."""
    file = scene_file(scene)
    try:
        content = regular(file).read_bytes()
    except (OSError, ValueError) as error:
        names = [*scene_names(), *scene_names(OF_MATRICES)]
        reason = f" ({error.strerror})" if isinstance(error, OSError) and error.strerror else ""
        meant = did_you_mean(file.stem, names)
        if file.stem in names:
            meant = f"; did you mean {file.stem!r}?"
        refuse("scene", str(scene), f"a TOML file, or one of {', '.join(names)}{reason}{meant}")
    try:
        data = tomllib.loads(content.decode())
    except (ValueError, RecursionError) as error:
        refuse("scene", str(scene), f"valid TOML in UTF-8: {error}")
    set_fields(data, overrides)
    return data


def changed(scene: Any, field: str | Mapping[str, Any], value: Any = None) -> dict[str, Any]:
    """Return the plain data of a scene with fields changed; parameters as ``Scene.change``."""
    data = plain_data(scene)
    for path, new in (field if isinstance(field, Mapping) else {field: value}).items():
        set_at(data, path, plain_data(new, path))
    return data


def set_fields(data: dict[str, Any], overrides: Iterable[str]) -> None:
    """Set fields of plain data from "path.to.field=value"; values that are not TOML are text."""
    for override in overrides:
        path, equals, text = override.partition("=")
        value: Any = text
        try:
            table = tomllib.loads(f"value = {text}")
            value = table["value"] if len(table) == 1 else text
        except (ValueError, RecursionError):
            pass
        if not equals:
            refuse("--set", override, "path.to.field=value")
        set_at(data, path, value)


def scene_names(folder: Path = SCENES) -> list[str]:
    """Return the names of the scenes that come with the project; ``OF_MATRICES`` has its own."""
    return sorted(file.stem for file in folder.glob("*.toml"))


def scene_file(scene: str | Path) -> Path:
    """Return the path of a scene's file; files in the working directory never shadow a name."""
    text = os.fspath(scene)
    if os.sep in text or "/" in text or text.endswith(".toml"):
        return Path(scene)
    of_matrices = OF_MATRICES / f"{text}.toml"
    return of_matrices if of_matrices.is_file() else SCENES / f"{text}.toml"


def is_of_matrices(scene: str | Path) -> bool:
    """Whether a scene file names matrices and no bodies."""
    tables = tables_of(scene)
    return "files" in tables and "bodies" not in tables


def scene_text(scene: Any) -> str:
    """Return a scene as TOML text, which reads back as the same scene."""
    data = _given(plain_data(scene))
    lines = _lines({name: value for name, value in data.items() if name not in _BY_NAME})
    for name in _BY_NAME:
        for entry, table in data.get(name, {}).items():
            lines += ["", f"[{name}.{_key(entry)}]", *_lines(table)]
    return "\n".join(lines) + "\n"


def _lines(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(name)} = {_toml(value)}" for name, value in table.items()]


def _given(value: Any) -> Any:
    """Return plain data without empty values and without None, which TOML does not have."""
    if isinstance(value, Mapping):
        parts = {name: _given(part) for name, part in value.items()}
        return {name: part for name, part in parts.items() if part not in (None, [], {})}
    if isinstance(value, list | tuple):
        return [_given(part) for part in value]
    return value


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value, ensure_ascii=False)
