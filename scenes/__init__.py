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
    from scenes.results.record import open_result as open_result
    from scenes.results.record import save_result as save_result
    from scenes.results.result import Result as Result
    from scenes.running.assembled import AssembledScene as AssembledScene
    from scenes.running.assembled import assemble as assemble
    from scenes.running.matrices import AssembledMatrices as AssembledMatrices
    from scenes.running.matrices import run_matrices as run_matrices
    from scenes.running.run import estimate_errors as estimate_errors
    from scenes.running.run import run_modes as run_modes
    from scenes.running.run import run_scene as run_scene
    from scenes.running.run import run_static as run_static
    from scenes.spec.matrices import MatrixScene as MatrixScene
    from scenes.spec.matrices import load_matrices as load_matrices
    from scenes.spec.matrices import read_matrix_scene as read_matrix_scene
    from scenes.spec.plain import scene_names as scene_names
    from scenes.spec.problems import SceneError as SceneError
    from scenes.spec.reading import Scene as Scene
    from scenes.spec.reading import load_scene as load_scene
    from scenes.spec.reading import read_scene as read_scene
    from scenes.spec.refinement import richer_scene as richer_scene

_OWNERS = {
    "cea.contact.formulations": ("Formulation", "register"),
    "scenes.checking.check": ("Inspection", "inspect_scene"),
    "scenes.results.record": ("open_result", "save_result"),
    "scenes.results.result": ("Result",),
    "scenes.running.assembled": ("AssembledScene", "assemble"),
    "scenes.running.matrices": ("AssembledMatrices", "run_matrices"),
    "scenes.running.run": ("estimate_errors", "run_modes", "run_scene", "run_static"),
    "scenes.spec.plain": ("scene_names",),
    "scenes.spec.matrices": ("MatrixScene", "load_matrices", "read_matrix_scene"),
    "scenes.spec.problems": ("SceneError",),
    "scenes.spec.reading": ("Scene", "load_scene", "read_scene"),
    "scenes.spec.refinement": ("richer_scene",),
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
