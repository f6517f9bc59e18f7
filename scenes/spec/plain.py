"""Scenes as plain data: in files, checked, changed along paths as ``loads[0].force``."""

import json
import os
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cea.errors import InputError, did_you_mean
from cea.files import regular
from scenes.spec.problems import SceneError, problems

SCENES = Path(__file__).parents[1] / "catalogue"
"""Folder of the scenes that come with the project."""
OF_MATRICES = SCENES / "matrices"
"""Folder of those whose matrices come from files."""
_LARGEST_FILE = 2**26
"""Bytes of a scene file."""
_KEYS = re.compile(r"(?<![^\s.,=\[\]{}])(?:[^\s.,=\[\]{}]+[ \t]*\.[ \t]*){100}")
"""A hundred tables inside each other by one dotted name, for which reading takes its time."""
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
    "SupportSpec": ("value",),
}
"""Fields that came later than stored numbers, which are found by fingerprints of their scenes: they
do not stand there where they have their defaults."""

Part = str | int
_STEP = re.compile(r"(?P<name>[^\[\]]+)(?P<numbers>(\[\d{1,9}\])*)")
"""A part of a path: a name, and numbers of entries in brackets behind it."""
_NUMBER = re.compile(r"\d{1,9}")
_HALF = re.compile(r"[\ud800-\udfff]")
"""Half of a character, which no file can hold."""
_BY_NAME = ("bodies", "contacts")
"""Tables whose entries are made whole: one field of what is not there is a name mistyped."""


def as_data(section: Any) -> Any:
    """A scene or a section of one as nested dictionaries, as ``dataclasses.asdict`` gives it."""
    if is_dataclass(section):
        later = _LATER.get(type(section).__name__, ())
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
    content = _json(data)
    try:
        return kind.validate_json(content)
    except ValidationError as error:
        raise SceneError(problems(error, json.loads(content), _schema(kind))) from error


@cache
def _schema(kind: TypeAdapter[Any]) -> dict[str, Any]:
    return kind.json_schema()


def plain_data(value: Any) -> Any:
    """A scene or a part of one as nested dictionaries, lists and numbers, which it is read from."""
    return json.loads(_json(value))


def _json(data: Any) -> bytes:
    """JSON of a scene or a part of one; refused is what JSON has no form for."""
    try:
        text = json.dumps(data, default=_plain, ensure_ascii=False)
        return text.encode()
    except UnicodeEncodeError:
        texts = [each for each in leaves(json.loads(text)) if _HALF.search(str(each[1]))]
        raise SceneError(InputError(*each, "text of whole characters") for each in texts) from None
    except (AttributeError, TypeError, ValueError, RecursionError) as error:
        allowed = f"text, numbers, lists, and tables of them by name, not too deep: {error}"
        raise SceneError([InputError("scene", "...", allowed)]) from error


def _plain(value: Any) -> Any:
    """What JSON has no form for: sections of scenes, and numbers and arrays of numpy."""
    return asdict(value) if is_dataclass(value) else value.tolist()


def leaves(data: Any, place: str = "scene") -> Iterator[tuple[str, Any]]:
    """Names and values of nested tables and lists, each with its path."""
    if not isinstance(data, Mapping | list | tuple):
        yield place, data
        return
    for name, part in data.items() if isinstance(data, Mapping) else enumerate(data):
        if isinstance(data, Mapping):
            yield place, name
        yield from leaves(part, f"{place}.{name}".removeprefix("scene."))


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
    parts = _parts(path)
    table: Any = data
    for i, part in enumerate(parts[:-1]):
        place, key = parts[: i + 1], _key(table, part, parts[: i + 1])
        if isinstance(table, dict) and table.get(key) is None:
            _check_new(table, place, parts[i + 1])
            table[key] = {}
        table = table[key]
        if not isinstance(table, dict | list):
            allowed = f"a table or a list, for {_text(parts)} to be set in it"
            raise InputError(_text(place), table, allowed)
    table[_key(table, parts[-1], parts)] = value


def _parts(path: str) -> list[Part]:
    parts: list[Part] = []
    for step in path.split("."):
        match = _STEP.fullmatch(step.strip())
        if match is None:
            allowed = "names with dots between, and whole numbers in brackets: loads[0].pressure"
            raise InputError("--set", path, allowed)
        parts += [match["name"], *map(int, _NUMBER.findall(match["numbers"]))]
    return parts


def _text(parts: Iterable[Part]) -> str:
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts)
    return text.removeprefix(".")


def _check_new(table: dict[str, Any], place: list[Part], below: Part) -> None:
    """Refuse to make what nobody can have meant: a list, or a part of a body that is not there."""
    allowed = ""
    if isinstance(below, int):
        allowed = "a list that is there to be counted in"
    elif len(place) == 2 and place[0] in _BY_NAME:
        allowed = "one that is there, or given whole"
    if allowed:
        there = f"{', '.join(map(str, table)) or 'none'}{did_you_mean(place[-1], table)}"
        raise InputError(_text(place), None, f"{allowed}; there are {there}")


def _key(table: Any, part: Part, place: list[Part]) -> Any:
    """What an entry is found by: a name in a table, the number of one that is there in a list."""
    if isinstance(table, list):
        number = int(part) if isinstance(part, int) or _NUMBER.fullmatch(part) else -1
        if not 0 <= number < len(table):
            there = f"from 0 to {len(table) - 1}" if table else "none: the list is empty"
            allowed = f"number of an entry of {_text(place[:-1])}: {there}"
            raise InputError(_text(place), part, allowed)
        return number
    if isinstance(part, int):
        allowed = f"a name: {_text(place[:-1])} is a table of {', '.join(map(str, table))}"
        raise InputError(_text(place), part, allowed)
    return part


def tables_of(scene: str | Path, overrides: Iterable[str] = ()) -> dict[str, Any]:
    """What a scene file says, with fields set; parameters are those of :func:`load_scene`."""
    file = scene_file(scene)
    try:
        with regular(file).open("rb") as stream:
            content = stream.read(_LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        names = [*scene_names(), *matrix_scene_names()]
        reason = f" ({error.strerror})" if isinstance(error, OSError) and error.strerror else ""
        meant = did_you_mean(file.stem, names)
        if file.stem in names:
            meant = f"; did you mean {file.stem!r}?"
        raise _refused(
            scene, f"a TOML file, or one of {', '.join(names)}{reason}{meant}"
        ) from error
    try:
        if len(content) > _LARGEST_FILE:
            raise ValueError(f"more than {_LARGEST_FILE} bytes")
        text = content.decode()
        if _KEYS.search(text):
            raise ValueError("names of more than 100 parts")
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise _refused(scene, f"valid TOML in UTF-8: {error}") from error
    set_fields(data, overrides)
    return data


def _refused(scene: str | Path, allowed: str) -> SceneError:
    return SceneError([InputError("scene", str(scene), allowed)])


def set_fields(data: dict[str, Any], overrides: Iterable[str]) -> None:
    """Set fields of plain data, each as "path.to.field=value" with a TOML value, else text."""
    for override in overrides:
        path, equals, text = override.partition("=")
        value: Any = text
        try:
            table = tomllib.loads(f"value = {text}")
            value = table["value"] if len(table) == 1 else text
        except (ValueError, RecursionError):
            pass
        try:
            if not equals:
                raise InputError("--set", override, "path.to.field=value")
            set_at(data, path.strip(), value)
        except InputError as error:
            raise SceneError([error]) from None


def scene_names() -> list[str]:
    """Names of the scenes of bodies that come with the project."""
    return sorted(file.stem for file in SCENES.glob("*.toml"))


def matrix_scene_names() -> list[str]:
    """Names of the scenes of matrices that come with the project."""
    return sorted(file.stem for file in OF_MATRICES.glob("*.toml"))


def scene_file(scene: str | Path) -> Path:
    """The file that is meant; what lies in the working directory never shadows a scene."""
    text = os.fspath(scene)
    if os.sep in text or "/" in text or text.endswith(".toml"):
        return Path(scene)
    of_matrices = OF_MATRICES / f"{text}.toml"
    return of_matrices if text in matrix_scene_names() else SCENES / f"{text}.toml"


def is_of_matrices(scene: str | Path) -> bool:
    """Whether a scene file names matrices and no bodies."""
    tables = tables_of(scene)
    return "files" in tables and "bodies" not in tables
