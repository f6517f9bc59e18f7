"""Problems that runs solve, and their answers: eigenvalues or stresses, verdicts, warnings."""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol

import numpy as np
from scipy.io import mmwrite, savemat
from scipy.sparse import csr_array, save_npz

from cea.arrays import Complexes, Floats
from cea.eigen.classify import classify_run, thresholds
from cea.eigen.driver import EigenSolver
from cea.petsc import PETSc
from cea.reduced.greedy import TOLERANCE, Enrichment
from cea.reduced.model import ReducedModel
from scenes import Result, run_scene
from scenes.results.record import as_json
from scenes.running.matrices import run_matrices
from scenes.running.system import coupled
from scenes.spec.matrices import read_matrix_scene
from scenes.spec.reading import Scene, read_scene

UNDECIDED, NOT_COMPLETE = "undecided", "window-not-complete"
"""Marks of answers with undecided modes, or with a window that may not be complete."""


@dataclass(frozen=True)
class Answer:
    """Modes of a run, with verdicts, error estimates and warnings."""

    eigenvalues: Complexes  # lambda (1/s), (n,)
    verdicts: tuple[str, ...]  # the verdict on each mode
    verdict: str  # the verdict on the whole window
    thresholds: Floats  # growth rate (1/s) above which each is called unstable, (n,)
    uncertainties: Floats  # error of lambda (1/s) that the run states for each, (n,)
    complete: bool  # whether the window claims to hold every mode
    max_frequency: float  # upper end of the window (Hz)
    residual: float  # the worst
    condition: float
    warnings: tuple[str, ...]  # their kinds
    dofs: int
    min_growth: float = -np.inf  # growth rate (1/s) down to which the window holds every mode

    @property
    def says(self) -> tuple[str, ...]:
        """Kinds of its warnings, and marks of undecided modes and an incomplete window."""
        undecided = "undecided" in (*self.verdicts, self.verdict)
        open_ends = [UNDECIDED] * undecided + [NOT_COMPLETE] * (not self.complete)
        return tuple(dict.fromkeys([*self.warnings, *open_ends]))


@dataclass(frozen=True)
class StressAnswer:
    """Normal stresses (N/m²) over both sides of the contacts of a static run, shape (n,)."""

    stresses: Floats
    says: tuple[str, ...]  # kinds of its warnings
    dofs: int


def _answer(result: Result) -> Answer | StressAnswer:
    """Answer of a result: its modes, or its stresses."""
    kinds = tuple(dict.fromkeys(warning.kind for warning in result.warnings))
    if result.spectrum is None:
        sides = [side.sigma_n for both in result.stresses.values() for side in both.values()]
        return StressAnswer(np.concatenate(sides), kinds, result.dofs)
    modes, threshold = result.modes, result.analysis.growth_threshold
    decay = modes.window.min_growth
    return Answer(
        eigenvalues=modes.eigenvalues,
        verdicts=tuple(modes.verdicts(threshold)),
        verdict=modes.verdict(threshold),
        thresholds=modes.thresholds(threshold),
        uncertainties=modes.growth_uncertainties,
        complete=modes.window.complete,
        max_frequency=modes.window.max_frequency,
        residual=float(modes.residuals.max(initial=0.0)),
        condition=float(modes.conditions.max(initial=1.0)),
        warnings=kinds,
        dofs=result.dofs,
        min_growth=-np.inf if decay is None else decay,
    )


class Problem(Protocol):
    """A problem to be solved; it raises an error if it is refused or does not converge."""

    def solve(self, max_frequency: float | None) -> Answer | StressAnswer:
        """Solve it up to a frequency (Hz), unless the problem sets its own."""
        ...


@dataclass(frozen=True)
class OfScene:
    """A scene as plain data; ``analysis.max_frequency`` may be left to the reference."""

    data: Mapping[str, Any]

    def solve(self, max_frequency: float | None) -> Answer | StressAnswer:
        """Read the scene and run it; check that the result can be stored."""
        result = run_scene(_read(self.data, max_frequency))
        as_json(result.data)
        return _answer(result)


def _read(given: Mapping[str, Any], max_frequency: float | None) -> Scene:
    """A scene, with the end of its window set if it gives none."""
    data = deepcopy(dict(given))
    if data["analysis"]["kind"] == "cea":
        data["analysis"].setdefault("max_frequency", max_frequency or 1.0)
    return read_scene(data)


@dataclass(frozen=True)
class OfMap:
    """A scene as one point of a map, by a reduced model of full solves at other points."""

    data: Mapping[str, Any]
    axes: Mapping[str, Sequence[float]]  # values of each parameter at the full solves

    def solve(self, max_frequency: float | None) -> Answer:
        """Solve the reduced model at the values of the scene."""
        scene = _read(self.data, max_frequency)
        system = coupled(scene, leave_out=False)[0]
        analysis: Any = scene.analysis
        pencil, top = system.pencil(), analysis.max_frequency
        box = {name: (min(values), max(values)) for name, values in self.axes.items()}
        model = ReducedModel(pencil, box, top, analysis.min_growth)
        built = Enrichment(model, EigenSolver(pencil))
        points = product(*self.axes.values())
        built.cover([dict(zip(self.axes, values, strict=True)) for values in points])
        found = built.at({}).window
        words = found.words(None)
        complete = all(each["complete"] for each in built.solves)
        return Answer(
            eigenvalues=found.eigenvalues,
            verdicts=tuple(words),
            verdict=classify_run(words, complete=complete),
            thresholds=thresholds(found.eigenvalues),
            uncertainties=found.uncertainties,
            complete=complete,
            max_frequency=top,
            residual=found.bound,
            condition=float(found.conditions.max(initial=1.0)),
            warnings=() if found.bound <= TOLERANCE else ("not-certified",),
            dofs=system.size,
        )


def _write_petsc(file: Path, matrix: csr_array) -> None:
    viewer = PETSc.Viewer().createBinary(str(file), "w", comm=PETSc.COMM_SELF)
    rows = matrix.indptr, matrix.indices, matrix.data
    PETSc.Mat().createAIJ(matrix.shape, csr=rows, comm=PETSc.COMM_SELF).view(viewer)
    viewer.destroy()


WRITERS: Mapping[str, Callable[[Path, csr_array], None]] = {
    "mat": lambda file, matrix: savemat(file, {"A": matrix}),
    "mtx": lambda file, matrix: mmwrite(file, matrix, precision=17),
    "npz": save_npz,
    "petsc": _write_petsc,
}
"""Functions that write a matrix, by the extension of the file."""


@dataclass(frozen=True)
class OfFiles:
    """Matrices M, K and perhaps C, shape (n, n), that are written to files and read again."""

    matrices: Mapping[str, Floats]
    form: str = "npz"  # of the files

    def solve(self, max_frequency: float | None) -> Answer | StressAnswer:
        """Write, read, and solve for the modes up to a frequency."""
        used = {name: matrix for name, matrix in self.matrices.items() if matrix.any()}
        with TemporaryDirectory() as folder:
            for name, matrix in used.items():
                WRITERS[self.form](Path(folder) / f"{name}.{self.form}", csr_array(matrix))
            scene = read_matrix_scene(
                {
                    "name": "files",
                    "data": folder,
                    "files": {name: f"{name}.{self.form}" for name in used},
                    "mass": {"M": 1.0},
                    "damping": {"C": 1.0} if "C" in used else {},
                    "stiffness": {"K": 1.0},
                    "analysis": {"kind": "cea", "max_frequency": max_frequency or 1.0},
                }
            )
            return _answer(run_matrices(scene))
