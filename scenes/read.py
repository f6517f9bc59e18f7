"""Scenes: read from files or plain data, changed, and refused when wrong before work begins."""

import json
import os
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cea.contact.formulations import Formulation, registered
from cea.errors import InputError
from cea.suggestions import did_you_mean
from scenes.checks import cross_checks
from scenes.every_fault import faults_of_the_rest
from scenes.faults import faults_told_by
from scenes.field_tree import FieldTree
from scenes.paths import set_at, set_by_text
from scenes.spec.body import Backend
from scenes.spec.scene import SceneSpec

SCENES = Path(__file__).parent / "catalogue"
"""Folder of the scenes that come with the project."""
OF_MATRICES = SCENES / "matrices"
"""Folder of those whose matrices come from files."""


_SHOWN = 20
"""Faults that a message tells."""
_LARGEST = 2**26
"""Bytes of a scene file."""
_DEEPEST = 100
"""Tables and lists inside each other."""
_WHOLE = 10**400
"""Whole numbers are smaller; beyond some thousand digits they cannot even be written."""
_KEYS = re.compile(r"(?<![^\s.,=\[\]{}])(?:[^\s.,=\[\]{}]+[ \t]*\.[ \t]*){100}")
"""A hundred tables inside each other by one dotted name, for which reading takes its time."""


class SceneError(ValueError):
    """A scene that is refused: one :class:`cea.errors.InputError` for each fault."""

    def __init__(self, faults: Iterable[InputError]) -> None:
        self.faults = tuple(faults)
        lines = [str(fault) for fault in self.faults[:_SHOWN]]
        if len(self.faults) > _SHOWN:
            lines.append(f"and {len(self.faults) - _SHOWN} more")
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel between ranks by its faults, not by its message."""
        return type(self), (self.faults,)


@dataclass(frozen=True)
class Scene(SceneSpec):
    """A scene whose parts suit each other."""

    @property
    def backends(self) -> str:
        """Backends of its bodies: "fe", "iga" or "fe+iga"."""
        return "+".join(sorted({body.backend for body in self.bodies.values()}))

    @property
    def damped(self) -> bool:
        """Whether anything damps, or feeds, small velocities."""
        damping = [body.damping for body in self.bodies.values() if body.damping is not None]
        sliding = [contact.sliding for contact in self.contacts.values()]
        return any(each.acts for each in damping) or any(sliding)

    @property
    def rotates(self) -> bool:
        """Whether a body rotates."""
        return any(body.rotation is not None for body in self.bodies.values())

    @property
    def slides_steadily(self) -> bool:
        """Whether a state of steady sliding is sought: a contact has a law of its closure."""
        return any(contact.c_n is not None for contact in self.contacts.values())

    @property
    def stiffened_by_stress(self) -> bool:
        """Whether the stresses of steady sliding stiffen, or soften, small motions."""
        return self.analysis.kind == "cea" and self.analysis.geometric_stiffness

    @property
    def prescribes(self) -> bool:
        """Whether a support holds anything elsewhere than at zero."""
        supports = [each.support() for body in self.bodies.values() for each in body.supports]
        return any(support.prescribes for support in supports)

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
        return read_scene(changed(self, field, value))

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
    data = tables_of(scene, overrides)
    if "files" in data and "bodies" not in data:
        allowed = "a scene of bodies; one of matrices is read by load_matrices"
        raise SceneError([InputError("scene", str(scene), allowed)])
    if backend is not None and isinstance(data.get("bodies"), dict):
        for body in data["bodies"].values():
            if isinstance(body, dict):
                body["backend"] = backend
    _set_paths(data, scene_file(scene).parent)
    return read_scene(data)


def _set_paths(data: Mapping[str, Any], folder: Path) -> None:
    """Take the files of meshes to be relative to the folder of the scene."""
    bodies = data.get("bodies")
    for body in bodies.values() if isinstance(bodies, dict) else ():
        geometry = body.get("geometry") if isinstance(body, dict) else None
        if isinstance(geometry, dict) and isinstance(geometry.get("file"), str):
            geometry["file"] = str(folder / geometry["file"])


def tables_of(scene: str | Path, overrides: Iterable[str] = ()) -> dict[str, Any]:
    """What a scene file says, with fields set; parameters are those of :func:`load_scene`.

    Raises
    ------
    SceneError
        When there is no such file, or no TOML in it, or a field cannot be set.
    """
    data = _toml(scene)
    set_fields(data, overrides)
    return data


def set_fields(data: dict[str, Any], overrides: Iterable[str]) -> None:
    """Set fields of plain data, each as "path.to.field=value" with a TOML value.

    Raises
    ------
    SceneError
        When one cannot be set.
    """
    for override in overrides:
        try:
            set_by_text(data, override)
        except InputError as error:
            raise SceneError([error]) from None


def _toml(scene: str | Path) -> dict[str, Any]:
    """What a scene file says."""
    file = scene_file(scene)
    try:
        if not file.is_file():
            raise FileNotFoundError
        with file.open("rb") as stream:
            content = stream.read(_LARGEST + 1)
    except (OSError, ValueError) as error:
        names = [*scene_names(), *matrix_scene_names()]
        allowed = f"a TOML file, or one of {', '.join(names)}"
        reason = f" ({error.strerror})" if isinstance(error, OSError) and error.strerror else ""
        meant = did_you_mean(file.stem, names) or _same_name(file, names)
        raise SceneError([InputError("scene", str(scene), allowed + reason + meant)]) from error
    if len(content) > _LARGEST:
        raise SceneError([InputError("scene", str(scene), f"a file of at most {_LARGEST} bytes")])
    try:
        text = content.decode()
        if _KEYS.search(text):
            raise ValueError(f"names of more than {_DEEPEST} parts")
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        allowed = f"valid TOML in UTF-8: {error}"
        raise SceneError([InputError("scene", str(scene), allowed)]) from error


def _same_name(file: Path, names: Iterable[str]) -> str:
    """The end of a message about a file that is not there, where a scene has its name."""
    return f"; did you mean {file.stem!r}?" if file.stem in names else ""


def scene_names() -> list[str]:
    """Names of the scenes of bodies that come with the project."""
    return sorted(file.stem for file in SCENES.glob("*.toml"))


def matrix_scene_names() -> list[str]:
    """Names of the scenes of matrices that come with the project."""
    return sorted(file.stem for file in OF_MATRICES.glob("*.toml"))


def read_scene(data: Mapping[str, Any]) -> Scene:
    """Check a scene given as nested dictionaries and make it a :class:`Scene`.

    Raises
    ------
    SceneError
        With one line for each fault.
    """
    adapter = _adapter(tuple(registered().values()))
    try:
        scene = checked(adapter, data)
    except SceneError as error:
        if not isinstance(error.__cause__, ValidationError):
            raise
        others = faults_of_the_rest(
            plain_data(data),
            error.__cause__,
            lambda rest: adapter.validate_json(json.dumps(rest)),
            cross_checks,
        )
        raise SceneError([*error.faults, *others]) from error.__cause__
    return _without_faults(scene)


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


def changed(scene: Any, field: str | Mapping[str, Any], value: Any = None) -> dict[str, Any]:
    """Plain data of a scene with fields changed, as :meth:`Scene.change` takes them."""
    data = plain_data(scene)
    for path, new in (field if isinstance(field, Mapping) else {field: value}).items():
        try:
            set_at(data, path, plain_data(new))
        except InputError as error:
            raise SceneError([error]) from None
    return data


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


def scene_file(scene: str | Path) -> Path:
    """The file that is meant; what lies in the working directory never shadows a scene."""
    text = os.fspath(scene)
    if os.sep in text or "/" in text or text.endswith(".toml"):
        return Path(scene)
    of_matrices = OF_MATRICES / f"{text}.toml"
    return of_matrices if text in matrix_scene_names() else SCENES / f"{text}.toml"


@cache
def _adapter(formulations: tuple[type[Formulation], ...]) -> TypeAdapter[Scene]:
    """What reads scenes that may name some formulations."""
    return TypeAdapter(Scene)


def _without_faults(scene: Scene) -> Scene:
    faults = list(cross_checks(scene))
    if faults:
        raise SceneError(faults)
    return scene
