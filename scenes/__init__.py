"""Scenes: files that describe bodies in contact, and what turns one into a result.

What a notebook needs is imported from here; each name brings in its module when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cea.contact.formulations import Formulation as Formulation
    from cea.contact.formulations import register as register
    from scenes.assembled import AssembledScene as AssembledScene
    from scenes.assembled import assemble as assemble
    from scenes.describe import save_result as save_result
    from scenes.inspection import Inspection as Inspection
    from scenes.inspection import inspect_scene as inspect_scene
    from scenes.matrix_run import AssembledMatrices as AssembledMatrices
    from scenes.matrix_run import MatrixResult as MatrixResult
    from scenes.matrix_run import run_matrices as run_matrices
    from scenes.matrix_scene import MatrixScene as MatrixScene
    from scenes.matrix_scene import load_matrices as load_matrices
    from scenes.matrix_scene import read_matrix_scene as read_matrix_scene
    from scenes.nested import estimate_errors as estimate_errors
    from scenes.opened import open_result as open_result
    from scenes.read import Scene as Scene
    from scenes.read import load_scene as load_scene
    from scenes.read import read_scene as read_scene
    from scenes.results import ModesResult as ModesResult
    from scenes.results import StaticResult as StaticResult
    from scenes.richer import richer_scene as richer_scene
    from scenes.run import run_modes as run_modes
    from scenes.run import run_scene as run_scene
    from scenes.run import run_static as run_static
    from scenes.scene_error import SceneError as SceneError
    from scenes.scene_files import scene_names as scene_names

_OWNERS = {
    "cea.contact.formulations": ("Formulation", "register"),
    "scenes.assembled": ("AssembledScene", "assemble"),
    "scenes.describe": ("save_result",),
    "scenes.inspection": ("Inspection", "inspect_scene"),
    "scenes.matrix_run": ("AssembledMatrices", "MatrixResult", "run_matrices"),
    "scenes.matrix_scene": ("MatrixScene", "load_matrices", "read_matrix_scene"),
    "scenes.nested": ("estimate_errors",),
    "scenes.opened": ("open_result",),
    "scenes.read": ("Scene", "load_scene", "read_scene"),
    "scenes.scene_error": ("SceneError",),
    "scenes.scene_files": ("scene_names",),
    "scenes.results": ("ModesResult", "StaticResult"),
    "scenes.richer": ("richer_scene",),
    "scenes.run": ("run_modes", "run_scene", "run_static"),
}
"""Names by the module they come from."""

_MODULES = {name: module for module, names in _OWNERS.items() for name in names}

__all__ = list(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted(_MODULES)
