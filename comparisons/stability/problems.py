"""What a run solves, and what its answer says: eigenvalues, and what it claims of them."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.sparse import csr_array, save_npz

from cea.arrays import Complexes, Floats
from scenes import run_scene
from scenes.results.record import as_json
from scenes.running.matrices import run_matrices
from scenes.spec.matrices import read_matrix_scene
from scenes.spec.reading import read_scene

UNDECIDED, NOT_COMPLETE = "undecided", "window-not-complete"
"""Kinds of what an answer leaves open."""


@dataclass(frozen=True)
class Answer:
    """Modes of a run, and what it says of them."""

    eigenvalues: Complexes  # lambda (1/s), (n,)
    verdicts: tuple[str, ...]  # the word of each mode
    verdict: str  # that of the whole window
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
        """Kinds of what it warns of: its warnings, modes undecided, a window not complete."""
        undecided = "undecided" in (*self.verdicts, self.verdict)
        open_ends = [UNDECIDED] * undecided + [NOT_COMPLETE] * (not self.complete)
        return tuple(dict.fromkeys([*self.warnings, *open_ends]))


def _answer(result: Any, dofs: int) -> Answer:
    """What the modes of a result say."""
    kinds = tuple(dict.fromkeys(warning.kind for warning in result.warnings))
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
        dofs=dofs,
        min_growth=-np.inf if decay is None else decay,
    )


@dataclass(frozen=True)
class OfScene:
    """A scene as plain data; ``analysis.max_frequency`` may be left to the reference."""

    data: Mapping[str, Any]

    def solve(self, max_frequency: float | None) -> Answer:
        """Read the scene and run it, up to a frequency (Hz) if it gives none.

        The result can be stored.
        """
        data = deepcopy(dict(self.data))
        if data["analysis"]["kind"] == "cea":
            data["analysis"].setdefault("max_frequency", max_frequency or 1.0)
        result = run_scene(read_scene(data))
        as_json(result.data)
        return _answer(result, result.system.size)


@dataclass(frozen=True)
class OfFiles:
    """Matrices M, K and perhaps C, shape (n, n), that are written to files and read again."""

    matrices: Mapping[str, Floats]

    def solve(self, max_frequency: float | None) -> Answer:
        """Write, read, and solve for the modes up to a frequency."""
        used = {name: matrix for name, matrix in self.matrices.items() if matrix.any()}
        with TemporaryDirectory() as folder:
            for name, matrix in used.items():
                save_npz(Path(folder) / f"{name}.npz", csr_array(matrix))
            scene = read_matrix_scene(
                {
                    "name": "files",
                    "data": folder,
                    "files": {name: f"{name}.npz" for name in used},
                    "mass": {"M": 1.0},
                    "damping": {"C": 1.0} if "C" in used else {},
                    "stiffness": {"K": 1.0},
                    "analysis": {"kind": "cea", "max_frequency": max_frequency or 1.0},
                }
            )
            result = run_matrices(scene)
        return _answer(result, result.dofs)


Problem = OfScene | OfFiles
"""What is solved; errors tell that it is refused, or has no answer."""
