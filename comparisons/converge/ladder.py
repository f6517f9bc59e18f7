"""Sequence of refined meshes of a scene on one backend, which depends on the scene alone.

Mesh i, from 0, has the elements of the scene in each direction times RATIO**(i - 2), and i graded
layers at singular edges: the third mesh has as many nodes as the scene's own, besides layers. Mesh
files keep their cells, with elements of degree i + 1.
"""

from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.driver import ABOVE
from cea.eigen.spectrum import Window
from cea.errors import ResultWarning
from comparisons.study.session import Progress
from meshes.mesh_file import MeshFile
from scenes import Result, run_modes
from scenes.checking.memory import check_memory, dofs_of
from scenes.running.run import estimate_errors
from scenes.spec.body import Backend
from scenes.spec.reading import Scene
from scenes.spec.refinement import (
    Resolution,
    from_file,
    has_singular_edges,
    on_backend_of_shapes,
    refined,
    richer_scene,
)

MESHES = 3
"""Meshes of an error bar: two differences give the order of convergence."""
RATIO = 1.5
"""Elements in each direction over those of the mesh before."""
LEAST_DEGREE = 3
"""Smallest degree, except for mesh files: degree 2 takes longer for three or more digits."""


@dataclass(frozen=True)
class Mesh:
    """Modes on one mesh by rising frequency, up to 5 per cent above the window of the scene."""

    resolution: Resolution
    scene: Scene  # with the window of the scene file
    dofs: int
    seconds: float  # of the run and the correction
    eigenvalues: Complexes  # lambda (1/s) with Im >= 0, shape (n,)
    uncertainties: Floats  # algebraic errors (1/s)
    rigid: NDArray[np.bool_]  # rigid body modes: lambda is zero to rounding
    stable: NDArray[np.bool_]  # modes that the run classifies as stable
    window: Window
    warnings: tuple[ResultWarning, ...]
    result: Result | None = field(repr=False)  # None once a finer mesh was matched
    corrected: Complexes | None = None  # lambda in the richer space, for error bars


class Ladder:
    """The sequence of meshes of a scene on one backend."""

    def __init__(self, scene: Scene, backend: Backend) -> None:
        _ = scene.window  # raises if the analysis has no modes
        on = on_backend_of_shapes(scene, backend)
        self.scene, self.backend = scene, backend
        self.by_degree = any(map(from_file, on.bodies.values()))
        self.least = 1 if self.by_degree else MESHES  # meshes needed for an error bar
        self._layered = has_singular_edges(on)
        self._slower = 1.0
        shapes = [body.mesh for body in on.bodies.values() if not from_file(body)]
        meshes = [shape.fe if backend == "fe" else shape.iga for shape in shapes]
        degrees = [int(np.max(mesh.degree)) for mesh in meshes if mesh is not None]
        self.degree = max([LEAST_DEGREE, *degrees])
        # Lagrange elements have as many nodes along a direction as elements times their degree.
        least = min(degrees, default=self.degree) if backend == "fe" else self.degree
        self._density = least / self.degree

    def resolution(self, number: int) -> Resolution | None:
        """Return the resolution of a mesh by number, from 0; None if mesh files have no more."""
        if self.by_degree and number >= MESHES:
            return None
        return Resolution(
            self.degree,
            self._density * RATIO ** (number - (MESHES - 1)),
            number if self._layered else 0,
            number + 1 if self.by_degree else None,
        )

    def seconds(self, number: int) -> float | None:
        """Return the expected time of a mesh and its correction (s); None if there is no such mesh.

        A mesh whose correction does not fit into memory is refused.
        """
        resolution = self.resolution(number)
        if resolution is None:
            return None
        wider = _widened(refined(self.scene, self.backend, resolution))
        richer = richer_scene(wider, by=None)
        check_memory(richer)
        # the correction takes about half of a run
        return self._slower * (_estimated_seconds(wider) + _estimated_seconds(richer) / 2)

    def run(self, number: int, progress: Progress) -> Mesh:
        """Compute the modes on a mesh, by number; collective."""
        resolution = self.resolution(number)
        assert resolution is not None
        begun, finer = perf_counter(), refined(self.scene, self.backend, resolution)
        wider = _widened(finer)
        result = run_modes(wider, left=True, listener=progress.stage)
        modes, seconds = result.modes, result.comm.bcast(perf_counter() - begun)
        self._slower = seconds / _estimated_seconds(wider)
        words = modes.verdicts(finer.window.growth_threshold)
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
        """Return the mesh with eigenvalues corrected in a richer space; collective."""
        own = mesh.result
        assert own is not None
        if not len(mesh.eigenvalues):
            return replace(mesh, corrected=mesh.eigenvalues)
        begun, richer = perf_counter(), richer_scene(own.scene, by=None)
        found = estimate_errors(own, richer, steps=1, listener=progress.stage)
        seconds = own.comm.bcast(perf_counter() - begun)
        return replace(mesh, corrected=found.corrected, seconds=mesh.seconds + seconds)


def elements_of(scene: Scene) -> dict[str, Any]:
    """Return the elements of each body in each direction, their size (m), or their number."""
    found: dict[str, Any] = {}
    for name, body in scene.bodies.items():
        mesh = body.division
        if isinstance(body.geometry, MeshFile):
            found[name] = body.geometry.elements.num_cells
        elif mesh is not None:
            found[name] = list(mesh.elements) if mesh.elements else getattr(mesh, "size", None)
    return found


def _widened(scene: Scene) -> Scene:
    """Return the scene with a larger window, so that modes at its end can be matched."""
    window = scene.window
    return replace(scene, analysis=replace(window, max_frequency=ABOVE * window.max_frequency))


def _estimated_seconds(scene: Scene) -> float:
    """Estimate the time of a run (s): setup and factors by nested dissection (George 1973)."""
    dofs = sum(map(dofs_of, scene.bodies.values()))
    plane = all(body.dim == 2 for body in scene.bodies.values())
    entries = 120.0 * dofs if plane else 40.0 * dofs ** (4 / 3)
    return 1.0 + 1e-7 * entries + 4e-11 * entries**1.5
