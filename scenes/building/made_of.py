"""What bodies and contact points of a scene are made of, and where two scenes differ.

A builder is given all of it and nothing else of the scene, so that scenes in which it is equal have
the same bodies, or points.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from cea.contact.formulations import Formulation
from meshes.mesh_file import MeshFile
from scenes.building.body_meshes import used_surfaces
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.load import LoadSpec
from scenes.spec.scene import SceneSpec


@dataclass(frozen=True)
class BodyParts:
    """What a body is made of."""

    spec: BodySpec
    loads: tuple[LoadSpec, ...] = ()
    surfaces: tuple[str, ...] = ()


def body_parts(scene: SceneSpec, name: str) -> BodyParts:
    """What a body of a scene is made of."""
    spec = scene.bodies[name]
    of_file = isinstance(spec.geometry, MeshFile)
    return BodyParts(
        replace(spec, damping=None, rotation=None),
        tuple(load for load in scene.loads if load.on == name),
        tuple(used_surfaces(scene, name)) if of_file else (),
    )


@dataclass(frozen=True)
class PointParts:
    """What the contact points of a half pass are made of, beside the two bodies."""

    a: str
    b: str
    formulation: Formulation
    reach: float | None
    max_missed: float
    full_pass: bool


def point_parts(spec: ContactSpec, *, opposite: bool = False) -> PointParts:
    """What the points of a contact are made of; opposite ones are those of the second half."""
    a, b = (spec.b, spec.a) if opposite else (spec.a, spec.b)
    return PointParts(a, b, spec.formulation, spec.reach, spec.max_missed, spec.full_pass)


class Built[Part](dict[str, Part]):
    """Bodies or contact points by name, with what each was made of."""

    def __init__(self, parts: Mapping[str, Part], made_of: Mapping[str, Any]) -> None:
        super().__init__(parts)
        self.made_of = dict(made_of)

    def made_of_the_same(self, wanted: Mapping[str, Any]) -> "Built[Part]":
        """Those that are made of what is wanted; itself where all are."""
        same = [name for name in wanted if name in self and self.made_of[name] == wanted[name]]
        if same == list(self):
            return self
        return Built({name: self[name] for name in same}, {name: wanted[name] for name in same})


def differences(old: Any, new: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Fields in which two sections of scenes differ: path, old and new value of each.

    Tables and lists are compared entry by entry where they have the same entries, else as a whole.
    """
    if old == new:
        return
    before, after = _entries(old), _entries(new)
    if type(old) is type(new) and before and before.keys() == after.keys():
        for name, value in before.items():
            yield from differences(value, after[name], f"{path}.{name}" if path else name)
    else:
        yield path, old, new


def _entries(section: Any) -> Mapping[str, Any]:
    """Entries of a section of a scene by name; none of a value."""
    if is_dataclass(section) and not isinstance(section, type):
        return {field.name: getattr(section, field.name) for field in fields(section)}
    if isinstance(section, Mapping):
        return section
    if isinstance(section, Sequence) and not isinstance(section, str):
        return {str(i): value for i, value in enumerate(section)}
    return {}
