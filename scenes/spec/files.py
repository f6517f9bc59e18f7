"""Files of scenes: where those that come with the project lie, and what a file says."""

import os
import re
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from cea.errors import InputError
from cea.files import regular
from cea.suggestions import did_you_mean
from scenes.spec.plain import set_at
from scenes.spec.problems import SceneError

SCENES = Path(__file__).parents[1] / "catalogue"
"""Folder of the scenes that come with the project."""
OF_MATRICES = SCENES / "matrices"
"""Folder of those whose matrices come from files."""
_LARGEST = 2**26
"""Bytes of a scene file."""
_KEYS = re.compile(r"(?<![^\s.,=\[\]{}])(?:[^\s.,=\[\]{}]+[ \t]*\.[ \t]*){100}")
"""A hundred tables inside each other by one dotted name, for which reading takes its time."""


def tables_of(scene: str | Path, overrides: Iterable[str] = ()) -> dict[str, Any]:
    """What a scene file says, with fields set; parameters are those of :func:`load_scene`."""
    file = scene_file(scene)
    try:
        with regular(file).open("rb") as stream:
            content = stream.read(_LARGEST + 1)
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
        if len(content) > _LARGEST:
            raise ValueError(f"more than {_LARGEST} bytes")
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
