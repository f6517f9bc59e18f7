"""Scenes read from TOML files, refused before work begins when wrong."""

import json
import tomllib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cea.errors import InputError
from scenes.checks import cross_checks, faults_told_by
from scenes.spec import Backend, Scene

SCENES = Path(__file__).parent / "catalogue"
"""Folder of the scenes that come with the project."""


class SceneError(ValueError):
    """A scene that is refused: one :class:`cea.errors.InputError` for each fault."""

    def __init__(self, faults: Iterable[InputError]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


@cache
def _adapter() -> TypeAdapter[Scene]:
    return TypeAdapter(Scene)


def load_scene(path: Path, overrides: Iterable[str] = (), backend: Backend | None = None) -> Scene:
    """Read a scene.

    Parameters
    ----------
    path
        TOML file, or the name of a scene that comes with the project.
    overrides
        Fields to set, each as "path.to.field=value" with a TOML value.
    backend
        Backend for every body; None leaves what the scene says.

    Raises
    ------
    SceneError
        With one line for each fault.
    """
    file = path if path.exists() else SCENES / f"{path}.toml"
    if not file.is_file():
        names = ", ".join(sorted(p.stem for p in SCENES.glob("*.toml")))
        raise SceneError([InputError("scene", str(path), f"a TOML file, or one of {names}")])
    try:
        data = tomllib.loads(file.read_text())
    except tomllib.TOMLDecodeError as error:
        raise SceneError([InputError("scene", str(path), f"valid TOML: {error}")]) from error
    for override in overrides:
        _set(data, override)
    if backend is not None and isinstance(data.get("bodies"), dict):
        for body in data["bodies"].values():
            if isinstance(body, dict):
                body["backend"] = backend
    return read_scene(data)


def read_scene(data: Mapping[str, Any]) -> Scene:
    """Check a scene given as nested dictionaries and make it a :class:`Scene`."""
    try:
        scene = _adapter().validate_json(json.dumps(data))
    except ValidationError as error:
        raise SceneError(faults_told_by(error)) from error
    faults = list(cross_checks(scene))
    if faults:
        raise SceneError(faults)
    return scene


def _set(data: dict[str, Any], override: str) -> None:
    path, equals, text = override.partition("=")
    if not equals:
        raise SceneError([InputError("--set", override, "path.to.field=value")])
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text
    *parents, last = path.strip().split(".")
    table = data
    for name in parents:
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            raise SceneError([InputError("--set", override, f"{name} is not a table")])
    table[last] = value
