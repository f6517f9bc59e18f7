"""One mesh of a sequence: a scene at a resolution, run."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.warned import ResultWarning
from comparisons.kit.progress import Progress
from scenes.memory import available_memory, estimated_memory, on_all_machines
from scenes.read import Scene
from scenes.refinement import Refiner, Resolution, refined
from scenes.results import ModesResult
from scenes.run import run_modes
from scenes.run_time import estimated_seconds
from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.spec.body import Backend

MARGIN = 1.02
"""Upper end of the search relative to that of the scene: modes at the end keep their partners."""


@dataclass(frozen=True)
class Level:
    """Modes on one mesh.

    Parameters
    ----------
    backend, resolution
        The mesh.
    scene
        The scene on it, with the window of the user.
    dofs
        Free dofs.
    seconds
        Time by the clock.
    estimated
        Time that was estimated before, not yet calibrated (s).
    eigenvalues
        lambda (1/s) with Im >= 0 by rising frequency, to a little beyond the window, shape (n,).
    uncertainties
        Errors of lambda by rounding and backward error (1/s), shape (n,).
    residuals
        Relative residuals, shape (n,).
    rigid
        Modes whose lambda is zero but for rounding, as nothing holds their motion, shape (n,).
    complete
        Whether the window is known to hold every mode.
    result
        The run; None once it is no longer compared with others.
    corrected
        Whether it is no run but the mesh before corrected in a richer space.
    warnings
        What the run must be read with.
    """

    backend: Backend
    resolution: Resolution
    scene: Scene
    dofs: int
    seconds: float
    estimated: float
    eigenvalues: Complexes
    uncertainties: Floats
    residuals: Floats
    rigid: NDArray[np.bool_]
    complete: bool
    result: ModesResult | None = field(repr=False)
    corrected: bool = False
    warnings: tuple[ResultWarning, ...] = ()

    def forgotten(self) -> "Level":
        """The level without its matrices and vectors."""
        return replace(self, result=None)

    def plain(self) -> dict[str, Any]:
        """Plain data, modes beyond the window left out."""
        return {
            "backend": self.backend,
            **self.resolution.plain(),
            "elements": elements_of(self.scene),
            "dofs": self.dofs,
            "seconds": self.seconds,
            "estimated": self.estimated,
            "complete": self.complete,
            "corrected": self.corrected,
        }


def elements_of(scene: Scene) -> dict[str, Any]:
    """Elements of each body along its directions, or their size (m)."""
    found: dict[str, Any] = {}
    for name, body in scene.bodies.items():
        mesh = body.mesh.fe if body.backend == "fe" else body.mesh.iga
        assert mesh is not None
        found[name] = list(mesh.elements) if mesh.elements else getattr(mesh, "size", None)
    return found


def given_elements(scene: Scene, backend: Backend) -> dict[str, tuple[int, ...] | None]:
    """Elements of the meshes of a scene along each direction; None of unstructured ones."""
    found: dict[str, tuple[int, ...] | None] = {}
    for name, body in scene.bodies.items():
        mesh = body.mesh.fe if backend == "fe" else body.mesh.iga
        found[name] = tuple(mesh.elements) if mesh is not None and mesh.elements else None
    return found


class Estimates:
    """Seconds that a scene takes at resolutions, from fits to earlier runs.

    Parameters
    ----------
    scene
        The scene as the user gives it.
    backend
        The backend.
    """

    def __init__(self, scene: Scene, backend: Backend) -> None:
        self._refiner = Refiner(widened(scene), backend)

    def seconds(self, resolution: Resolution, room: float = inf) -> float:
        """Seconds at a resolution, infinite where it takes more memory (bytes) than there is."""
        finer = self._refiner.at(resolution)
        memory = estimated_memory(finer)
        return estimated_seconds(finer, memory) if memory.bytes <= room else inf

    def fitting(self) -> Callable[[Resolution], float]:
        """Seconds, infinite where the memory that is free now does not do; collective."""
        return partial(self.seconds, room=on_all_machines(available_memory))


def estimate(scene: Scene, backend: Backend, resolution: Resolution) -> float:
    """Seconds that a scene takes at one resolution, from fits to earlier runs."""
    return Estimates(scene, backend).seconds(resolution)


def widened(scene: Scene) -> Scene:
    """The scene with a window that reaches a little farther."""
    analysis = scene.analysis
    assert isinstance(analysis, ComplexEigenvalueAnalysis)
    wider = replace(analysis, max_frequency=MARGIN * analysis.max_frequency)
    return replace(scene, analysis=wider)


def run_level(scene: Scene, backend: Backend, resolution: Resolution, progress: Progress) -> Level:
    """Run a scene at a resolution; collective.

    Parameters
    ----------
    scene
        The scene as the user gives it.
    backend, resolution
        The mesh.
    progress
        Told the stages.

    Raises
    ------
    InputError
        When the machine has not the memory it takes.
    ConvergenceError
        When modes are lost to rounding.
    """
    finer = refined(scene, backend, resolution)
    begun = perf_counter()
    result = run_modes(widened(finer), left=True, listener=progress.stage)
    # Decisions hang on times, which differ from rank to rank.
    seconds = result.comm.bcast(perf_counter() - begun)
    return Level(
        backend,
        resolution,
        finer,
        result.dofs,
        seconds,
        estimate(scene, backend, resolution),
        result.eigenvalues,
        result.modes.growth_uncertainties,
        result.modes.residuals,
        result.modes.rigid,
        result.modes.window.complete,
        result,
        warnings=result.warnings,
    )
