"""Scenes changed: every body on one backend, fields of every contact."""

from dataclasses import replace
from typing import Any

from scenes.spec.body import Backend
from scenes.spec.reading import Scene

BACKENDS: tuple[Backend, ...] = ("fe", "iga")


def on_backend(scene: Scene, backend: Backend) -> Scene:
    """The scene with every body on one backend."""
    return replace(scene, bodies={n: replace(b, backend=backend) for n, b in scene.bodies.items()})


def with_contact(scene: Scene, **changes: Any) -> Scene:
    """The scene with changed fields of every contact."""
    return replace(scene, contacts={n: replace(c, **changes) for n, c in scene.contacts.items()})
