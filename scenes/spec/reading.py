"""Scenes read from files or plain data, and refused when wrong before work begins."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from cea.contact.formulations import Formulation, registered
from cea.errors import InputError
from scenes.spec.body import Backend
from scenes.spec.consistency import cross_checks
from scenes.spec.files import scene_file, tables_of
from scenes.spec.paths import set_at
from scenes.spec.plain import checked, plain_data
from scenes.spec.problems import SceneError
from scenes.spec.scene import SceneSpec, on_backend


@dataclass(frozen=True)
class Scene(SceneSpec):
    """A scene whose parts suit each other."""

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
        return _without_faults(on_backend(self, backend))


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
    bodies = data.get("bodies")
    for body in bodies.values() if isinstance(bodies, dict) else ():
        if isinstance(body, dict):
            if backend is not None:
                body["backend"] = backend
            geometry = body.get("geometry")
            if isinstance(geometry, dict) and isinstance(geometry.get("file"), str):
                geometry["file"] = str(scene_file(scene).parent / geometry["file"])
    return read_scene(data)


def read_scene(data: Mapping[str, Any]) -> Scene:
    """Check a scene given as nested dictionaries and make it a :class:`Scene`.

    Raises
    ------
    SceneError
        With one line for each fault: those of single fields, and when these are right those
        between fields.
    """
    return _without_faults(checked(_adapter(tuple(registered().values())), data))


def changed(scene: Any, field: str | Mapping[str, Any], value: Any = None) -> dict[str, Any]:
    """Plain data of a scene with fields changed, as :meth:`Scene.change` takes them."""
    data = plain_data(scene)
    for path, new in (field if isinstance(field, Mapping) else {field: value}).items():
        try:
            set_at(data, path, plain_data(new))
        except InputError as error:
            raise SceneError([error]) from None
    return data


def _without_faults(scene: Scene) -> Scene:
    """A scene, refused where its fields do not suit each other."""
    faults = list(cross_checks(scene))
    if faults:
        raise SceneError(faults)
    return scene


@cache
def _adapter(formulations: tuple[type[Formulation], ...]) -> TypeAdapter[Scene]:
    """What reads scenes that may name some formulations."""
    return TypeAdapter(Scene)
