"""Scenes: files that describe bodies in contact, and what turns one into a result.

What a notebook needs is imported from here; each name brings in its module when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cea.contact.formulations import Formulation as Formulation
    from cea.contact.formulations import register as register
    from scenes.checking.check import Inspection as Inspection
    from scenes.checking.check import inspect_scene as inspect_scene
    from scenes.results.describe import save_result as save_result
    from scenes.results.opened import open_result as open_result
    from scenes.results.result import ModesResult as ModesResult
    from scenes.results.result import StaticResult as StaticResult
    from scenes.running.assembled import AssembledScene as AssembledScene
    from scenes.running.assembled import assemble as assemble
    from scenes.running.enrich import richer_scene as richer_scene
    from scenes.running.matrices import AssembledMatrices as AssembledMatrices
    from scenes.running.matrices import MatrixResult as MatrixResult
    from scenes.running.matrices import run_matrices as run_matrices
    from scenes.running.nested import estimate_errors as estimate_errors
    from scenes.running.run import run_modes as run_modes
    from scenes.running.run import run_scene as run_scene
    from scenes.running.run import run_static as run_static
    from scenes.spec.files import scene_names as scene_names
    from scenes.spec.matrices import MatrixScene as MatrixScene
    from scenes.spec.matrices import load_matrices as load_matrices
    from scenes.spec.matrices import read_matrix_scene as read_matrix_scene
    from scenes.spec.problems import SceneError as SceneError
    from scenes.spec.reading import Scene as Scene
    from scenes.spec.reading import load_scene as load_scene
    from scenes.spec.reading import read_scene as read_scene

_OWNERS = {
    "cea.contact.formulations": ("Formulation", "register"),
    "scenes.running.assembled": ("AssembledScene", "assemble"),
    "scenes.results.describe": ("save_result",),
    "scenes.checking.check": ("Inspection", "inspect_scene"),
    "scenes.running.matrices": ("AssembledMatrices", "MatrixResult", "run_matrices"),
    "scenes.spec.matrices": ("MatrixScene", "load_matrices", "read_matrix_scene"),
    "scenes.running.nested": ("estimate_errors",),
    "scenes.results.opened": ("open_result",),
    "scenes.spec.reading": ("Scene", "load_scene", "read_scene"),
    "scenes.spec.problems": ("SceneError",),
    "scenes.spec.files": ("scene_names",),
    "scenes.results.result": ("ModesResult", "StaticResult"),
    "scenes.running.enrich": ("richer_scene",),
    "scenes.running.run": ("run_modes", "run_scene", "run_static"),
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
