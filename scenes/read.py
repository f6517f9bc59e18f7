"""Scenes: read from files or plain data, changed, and refused when wrong before work begins."""

import json
import os
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cea.contact.formulations import Formulation, registered
from cea.errors import InputError
from scenes.checks import cross_checks, faults_told_by
from scenes.spec import Backend, SceneSpec

SCENES = Path(__file__).parent / "catalogue"
"""Folder of the scenes that come with the project."""


class SceneError(ValueError):
    """A scene that is refused: one :class:`cea.errors.InputError` for each fault."""

    def __init__(self, faults: Iterable[InputError]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


@dataclass(frozen=True)
class Scene(SceneSpec):
    """A scene whose parts suit each other."""

    @property
    def backends(self) -> str:
        """Backends of its bodies: "fe", "iga" or "fe+iga"."""
        return "+".join(sorted({body.backend for body in self.bodies.values()}))

    def change(self, field: str | Mapping[str, Any], value: Any = None) -> "Scene":
        """The scene with fields changed, checked anew as a file is.

        Parameters
        ----------
        field
            Path of a field, e.g. "contacts.pad_disc.mu"; or values of several by their paths.
        value
            Value of the one field: plain data as in a file, or a section such as a formulation.

        Raises
        ------
        SceneError
            With one line for each fault.
        """
        data = plain_data(self)
        for path, new in (field if isinstance(field, Mapping) else {field: value}).items():
            _set(data, path, plain_data(new))
        return read_scene(data)

    def on(self, backend: Backend) -> "Scene":
        """The scene with every body on one backend.

        Raises
        ------
        SceneError
            When a body has no mesh there, or a formulation does not suit it.
        """
        bodies = {name: replace(body, backend=backend) for name, body in self.bodies.items()}
        return _without_faults(replace(self, bodies=bodies))


def load_scene(
    scene: str | Path, overrides: Iterable[str] = (), backend: Backend | None = None
) -> Scene:
    """Read a scene.

    Parameters
    ----------
    scene
        Name of a scene that comes with the project; or a TOML file, which is told by its ending
        or by a separator in its path.
    overrides
        Fields to set, each as "path.to.field=value" with a TOML value.
    backend
        Backend for every body; None leaves what the scene says.

    Raises
    ------
    SceneError
        With one line for each fault.
    """
    file = _file(scene)
    if not file.is_file():
        names = ", ".join(scene_names())
        raise SceneError([InputError("scene", str(scene), f"a TOML file, or one of {names}")])
    try:
        data = tomllib.loads(file.read_text())
    except tomllib.TOMLDecodeError as error:
        raise SceneError([InputError("scene", str(scene), f"valid TOML: {error}")]) from error
    for override in overrides:
        path, equals, text = override.partition("=")
        if not equals:
            raise SceneError([InputError("--set", override, "path.to.field=value")])
        _set(data, path.strip(), _toml_value(text))
    if backend is not None and isinstance(data.get("bodies"), dict):
        for body in data["bodies"].values():
            if isinstance(body, dict):
                body["backend"] = backend
    return read_scene(data)


def scene_names() -> list[str]:
    """Names of the scenes that come with the project."""
    return sorted(file.stem for file in SCENES.glob("*.toml"))


def read_scene(data: Mapping[str, Any]) -> Scene:
    """Check a scene given as nested dictionaries and make it a :class:`Scene`.

    Raises
    ------
    SceneError
        With one line for each fault.
    """
    try:
        scene = _adapter(tuple(registered().values())).validate_json(json.dumps(data))
    except ValidationError as error:
        raise SceneError(faults_told_by(error)) from error
    return _without_faults(scene)


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


def _file(scene: str | Path) -> Path:
    """The file that is meant; what lies in the working directory never shadows a scene."""
    text = os.fspath(scene)
    named = os.sep not in text and "/" not in text and not text.endswith(".toml")
    return SCENES / f"{text}.toml" if named else Path(scene)


@cache
def _adapter(formulations: tuple[type[Formulation], ...]) -> TypeAdapter[Scene]:
    """What reads scenes that may name some formulations."""
    return TypeAdapter(Scene)


def _without_faults(scene: Scene) -> Scene:
    faults = list(cross_checks(scene))
    if faults:
        raise SceneError(faults)
    return scene


def _toml_value(text: str) -> Any:
    """Value of a field as TOML has it; what TOML has no value for is text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _set(data: dict[str, Any], path: str, value: Any) -> None:
    """Set a field by its path through tables and lists; tables that are not there are made."""
    *parents, last = path.split(".")
    table: Any = data
    for name in parents:
        table = _entry(table, name, path)
    if isinstance(table, list):
        table[_number(table, last, path)] = value
    else:
        table[last] = value


def _entry(table: Any, name: str, path: str) -> Any:
    """The table or list that a table or list holds under a name."""
    if isinstance(table, list):
        entry = table[_number(table, name, path)]
    else:
        if table.get(name) is None:
            table[name] = {}
        entry = table[name]
    if not isinstance(entry, dict | list):
        raise SceneError([InputError(path, entry, f"a path of tables: {name} is none")])
    return entry


def _number(entries: list[Any], name: str, path: str) -> int:
    if not (name.isdecimal() and int(name) < len(entries)):
        allowed = f"a number from 0 to {len(entries) - 1}" if entries else "no entry: there is none"
        raise SceneError([InputError(path, name, allowed)])
    return int(name)
