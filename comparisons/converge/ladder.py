"""Meshes of a scene on one backend, each finer than the one before; they depend on the scene alone.

Mesh number i, from 0, has the elements of the scene along each direction times the ratio to the
power of i - 2, and i layers at singular edges: the third has the nodes of the scene's own, but for
layers. On the cells of mesh files elements have degree i + 1.
"""

from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.driver import ABOVE
from cea.eigen.spectrum import Window
from cea.errors import InputError
from cea.warned import ResultWarning
from comparisons.kit.progress import Progress
from scenes import Result, run_modes
from scenes.checking.memory import estimated_memory
from scenes.refinement.meshes import (
    Resolution,
    from_file,
    has_singular_edges,
    on_backend_of_shapes,
    refined,
)
from scenes.running.enrich import enriched_scene
from scenes.running.nested import estimate_errors
from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.spec.body import Backend
from scenes.spec.reading import Scene

MESHES = 3
"""Meshes of a bar: two differences show the order of convergence."""
RATIO = 1.5
"""Elements along each direction relative to those of the mesh before."""
LEAST_DEGREE = 3
"""Least degree of the elements of shapes: degree 2 takes more time for three digits, or more."""


@dataclass(frozen=True)
class Mesh:
    """Modes on one mesh.

    Parameters
    ----------
    resolution, scene
        How fine it is, and the scene on it with the window of the user.
    dofs
        Free dofs.
    seconds
        Time by the clock, of the run and of the correction.
    eigenvalues
        lambda (1/s) with Im >= 0 by rising frequency, to 5 per cent above the window, shape (n,).
    uncertainties
        Errors of lambda by rounding and backward error (1/s), shape (n,).
    rigid
        Modes whose lambda is zero but for rounding, shape (n,).
    stable
        Modes that the run knows to be stable, shape (n,).
    window
        What was searched.
    warnings
        What the run must be read with.
    result
        The run; None once it is no longer compared with others.
    corrected
        lambda in a richer space (1/s), shape (n,); None where they were not corrected.
    """

    resolution: Resolution
    scene: Scene
    dofs: int
    seconds: float
    eigenvalues: Complexes
    uncertainties: Floats
    rigid: NDArray[np.bool_]
    stable: NDArray[np.bool_]
    window: Window
    warnings: tuple[ResultWarning, ...]
    result: Result | None = field(repr=False)
    corrected: Complexes | None = None


class Ladder:
    """The meshes of a scene on one backend.

    Parameters
    ----------
    scene
        The scene as the user gives it.
    backend
        Backend of every shape.

    Raises
    ------
    InputError
        When the analysis is static, or a shape has no mesh of the backend.
    """

    def __init__(self, scene: Scene, backend: Backend) -> None:
        window_of(scene)
        on = on_backend_of_shapes(scene, backend)
        self.scene, self.backend = scene, backend
        self.by_degree = any(map(from_file, on.bodies.values()))
        self._layered = has_singular_edges(on)
        self._slower = 1.0
        degrees = [int(np.max(each.degree)) for each in _meshes_of_shapes(on)]
        self.degree = max([LEAST_DEGREE, *degrees])
        # Lagrange elements have as many nodes along a direction as elements times their degree.
        least = min(degrees, default=self.degree) if backend == "fe" else self.degree
        self._density = least / self.degree

    def resolution(self, number: int) -> Resolution | None:
        """How fine the mesh of a number is, from 0; None where mesh files have no further one."""
        if self.by_degree and number >= MESHES:
            return None
        return Resolution(
            self.degree,
            self._density * RATIO ** (number - (MESHES - 1)),
            number if self._layered else 0,
            number + 1 if self.by_degree else None,
        )

    def seconds(self, number: int) -> float | None:
        """Time that a mesh and its correction are expected to take (s); None where none is left."""
        resolution = self.resolution(number)
        if resolution is None:
            return None
        finer = refined(self.scene, self.backend, resolution)
        own = self._slower * _estimated_seconds(_widened(finer))
        return own + self.seconds_to_correct(finer)

    def seconds_to_correct(self, scene: Scene) -> float:
        """Time that the correction of a mesh is expected to take (s): half of that of a run."""
        return self._slower * _estimated_seconds(enriched_scene(_widened(scene))) / 2

    def run(self, number: int, progress: Progress) -> Mesh:
        """Modes on the mesh of a number; collective.

        Raises
        ------
        InputError
            When the machine has not the memory it takes.
        ConvergenceError
            When modes are lost to rounding.
        """
        resolution = self.resolution(number)
        assert resolution is not None
        begun, finer = perf_counter(), refined(self.scene, self.backend, resolution)
        wider = _widened(finer)
        result = run_modes(wider, left=True, listener=progress.stage)
        modes, seconds = result.modes, result.comm.bcast(perf_counter() - begun)
        self._slower = seconds / _estimated_seconds(wider)
        words = modes.verdicts(window_of(finer).growth_threshold)
        return Mesh(
            resolution,
            finer,
            result.dofs,
            seconds,
            result.eigenvalues,
            modes.growth_uncertainties,
            modes.rigid,
            np.array([word == "stable" for word in words], dtype=bool),
            modes.window,
            result.warnings,
            result,
        )

    def correct(self, mesh: Mesh, progress: Progress) -> Mesh:
        """A mesh whose modes are corrected in a richer space; collective.

        Raises
        ------
        InputError
            When the machine has not the memory it takes, or there is no richer space.
        """
        assert mesh.result is not None
        if not len(mesh.eigenvalues):
            return replace(mesh, corrected=mesh.eigenvalues)
        begun, own = perf_counter(), mesh.result
        richer = enriched_scene(own.scene)
        found = estimate_errors(own, richer, listener=progress.stage)
        seconds = own.comm.bcast(perf_counter() - begun)
        return replace(mesh, corrected=found.corrected, seconds=mesh.seconds + seconds)


def elements_of(scene: Scene) -> dict[str, Any]:
    """Elements of each body along its directions, their size (m), or how many a file has."""
    found: dict[str, Any] = {}
    for name, body in scene.bodies.items():
        mesh = body.mesh.fe if body.backend == "fe" else body.mesh.iga
        if mesh is None:
            found[name] = getattr(body.geometry, "num_cells", None)
        else:
            found[name] = list(mesh.elements) if mesh.elements else getattr(mesh, "size", None)
    return found


def _meshes_of_shapes(scene: Scene) -> list[Any]:
    bodies = [body for body in scene.bodies.values() if not from_file(body)]
    return [body.mesh.fe if body.backend == "fe" else body.mesh.iga for body in bodies]


def window_of(scene: Scene) -> ComplexEigenvalueAnalysis:
    """What modes a scene asks for.

    Raises
    ------
    InputError
        When its analysis is static.
    """
    if not isinstance(scene.analysis, ComplexEigenvalueAnalysis):
        raise InputError("analysis.kind", scene.analysis.kind, "'cea', which has eigenvalues")
    return scene.analysis


def _widened(scene: Scene) -> Scene:
    """The scene with a window that reaches a little farther: modes at the end keep partners."""
    window = window_of(scene)
    return replace(scene, analysis=replace(window, max_frequency=ABOVE * window.max_frequency))


def _estimated_seconds(scene: Scene) -> float:
    entries = estimated_memory(scene).factor_entries
    return 1e-7 * entries + 4e-11 * entries**1.5
