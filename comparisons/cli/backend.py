"""The option ``--backend`` of commands that take a scene apart by its overrides."""

from collections.abc import Sequence
from typing import Literal


def with_backend(
    scene: str, overrides: Sequence[str], backend: Literal["fe", "iga"] | None
) -> tuple[str, ...]:
    """Overrides that put every body on one backend, behind others.

    Parameters
    ----------
    scene
        TOML file, or the name of a scene.
    overrides
        Of other fields.
    backend
        The backend; None leaves what the scene says.

    Raises
    ------
    InputError
        When the scene is one of matrices, which has no bodies.
    SceneError
        When the scene is refused there.
    """
    if backend is None:
        return tuple(overrides)
    from cea.errors import InputError
    from scenes.spec.files import is_of_matrices
    from scenes.spec.reading import load_scene

    if is_of_matrices(scene):
        allowed = "left out: a scene of matrices has no bodies"
        raise InputError("backend", backend, allowed)
    bodies = load_scene(scene, overrides, backend).bodies
    return (*overrides, *(f'bodies.{name}.backend="{backend}"' for name in bodies))
