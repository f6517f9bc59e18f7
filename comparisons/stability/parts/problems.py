"""What a run solves, and what its answer says: eigenvalues or stresses, and what it claims."""

from collections.abc import Iterable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Complexes, Floats
from cea.eigen.classify import classify_run, thresholds
from cea.eigen.driver import EigenSolver, solve_modes
from cea.eigen.pencil import Pencil
from cea.eigen.spectrum import Spectrum
from cea.errors import ResultWarning
from cea.matrices import distributed
from cea.petsc import MPI
from cea.reduced.greedy import TOLERANCE, Enrichment
from cea.reduced.model import ReducedModel
from scenes import run_scene
from scenes.results.record import as_json
from scenes.running.system import coupled
from scenes.spec.reading import Scene, read_scene

UNDECIDED, NOT_COMPLETE = "undecided", "window-not-complete"
"""Kinds of what an answer leaves open."""


@dataclass(frozen=True)
class ModesAnswer:
    """Modes of a run, and what it says of them.

    Parameters
    ----------
    eigenvalues
        Lambda (1/s), shape (n,).
    verdicts
        The word of each mode.
    verdict
        That of the whole window.
    thresholds
        Growth rate (1/s) above which each is called unstable, shape (n,).
    uncertainties
        Error of lambda (1/s) that the run states for each, shape (n,).
    complete
        Whether the window claims to hold every mode.
    max_frequency
        Upper end of the window (Hz).
    residual, condition
        The worst of both.
    warnings
        Kinds of its warnings.
    dofs
        Number of unknowns.
    min_growth
        Growth rate (1/s) down to which the window holds every mode.
    """

    eigenvalues: Complexes
    verdicts: tuple[str, ...]
    verdict: str
    thresholds: Floats
    uncertainties: Floats
    complete: bool
    max_frequency: float
    residual: float
    condition: float
    warnings: tuple[str, ...]
    dofs: int
    min_growth: float = -np.inf

    @property
    def modes(self) -> int:
        """How many there are."""
        return len(self.eigenvalues)

    @property
    def says(self) -> tuple[str, ...]:
        """Kinds of what it warns of: its warnings, modes undecided, a window not complete."""
        undecided = "undecided" in (*self.verdicts, self.verdict)
        open_ends = [UNDECIDED] * undecided + [NOT_COMPLETE] * (not self.complete)
        return tuple(dict.fromkeys([*self.warnings, *open_ends]))


@dataclass(frozen=True)
class StressAnswer:
    """Normal stresses (N/m^2) over both sides of the contacts of a static run, shape (n,)."""

    stresses: Floats
    warnings: tuple[str, ...]
    dofs: int

    @property
    def says(self) -> tuple[str, ...]:
        """Kinds of what it warns of."""
        return self.warnings


Answer = ModesAnswer | StressAnswer


def answer_of(
    modes: Spectrum, warnings: Iterable[ResultWarning], threshold: float | None, dofs: int
) -> ModesAnswer:
    """What a spectrum says; the threshold (1/s) of growth is relative where it is None."""
    decays = modes.window.min_growth
    return ModesAnswer(
        eigenvalues=modes.eigenvalues,
        verdicts=tuple(modes.verdicts(threshold)),
        verdict=modes.verdict(threshold),
        thresholds=modes.thresholds(threshold),
        uncertainties=modes.growth_uncertainties,
        complete=modes.window.complete,
        max_frequency=modes.window.max_frequency,
        min_growth=-np.inf if decays is None else decays,
        residual=float(modes.residuals.max(initial=0.0)),
        condition=float(modes.conditions.max(initial=1.0)),
        warnings=_kinds(warnings),
        dofs=dofs,
    )


def _of_result(result: Any, dofs: int) -> ModesAnswer:
    return answer_of(result.modes, result.warnings, result.analysis.growth_threshold, dofs)


def _kinds(warnings: Iterable[ResultWarning]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(warning.kind for warning in warnings))


class Problem(Protocol):
    """Something that is solved."""

    def solve(self, max_frequency: float | None) -> Answer:
        """Solve it.

        Parameters
        ----------
        max_frequency
            Upper end of the modes wanted (Hz), where the problem does not say it.

        Raises
        ------
        InputError, SceneError
            When it is refused.
        ConvergenceError
            When it has no answer.
        """
        ...


@dataclass(frozen=True)
class OfScene:
    """A scene as plain data; ``analysis.max_frequency`` may be left to the reference."""

    data: Mapping[str, Any]

    def solve(self, max_frequency: float | None) -> Answer:
        """Read the scene and run it; the result can be stored."""
        result = run_scene(_read(self.data, max_frequency))
        as_json(result.data)
        if result.spectrum is not None:
            return _of_result(result, result.system.size)
        stresses = [side.sigma_n for sides in result.stresses.values() for side in sides.values()]
        return StressAnswer(np.concatenate(stresses), _kinds(result.warnings), result.system.size)


@dataclass(frozen=True)
class OfMatrices:
    """Given matrices, lambda^2 M + K - F: symmetric K, M and unsymmetric F, shape (n, n)."""

    stiffness: Floats
    mass: Floats
    friction: Floats

    def solve(self, max_frequency: float | None) -> Answer:
        """Modes up to a frequency."""
        assert max_frequency is not None
        n = len(self.stiffness)
        S, M, F = (
            distributed(csr_array(matrix), (n, n), MPI.COMM_SELF)
            for matrix in (self.stiffness, self.mass, self.friction)
        )
        for matrix in (S, M):
            matrix.setOption(matrix.Option.SYMMETRIC, True)
        modes = solve_modes(Pencil.of(S, M, F if self.friction.any() else None), max_frequency)
        return answer_of(modes, modes.warnings, None, n)


@dataclass(frozen=True)
class OfMap:
    """A scene as one value of a map: a reduced model answers.

    Parameters
    ----------
    data
        The scene.
    axes
        Values of parameters between which full solves are made; the scene's own are not among
        them.
    """

    data: Mapping[str, Any]
    axes: Mapping[str, Sequence[float]]

    def solve(self, max_frequency: float | None) -> ModesAnswer:
        """The reduced model at the values of the scene."""
        scene = _read(self.data, max_frequency)
        system, _, _ = coupled(scene, leave_out=False)
        pencil, top = system.pencil(leave_out=False), _end(scene)
        box = {name: (float(min(each)), float(max(each))) for name, each in self.axes.items()}
        model = ReducedModel(pencil, box, top, self.data["analysis"].get("min_growth"))
        built = Enrichment.of(model, EigenSolver(pencil))
        points = product(*self.axes.values())
        built.cover([dict(zip(self.axes, values, strict=True)) for values in points])
        found = built.at({}).window
        words = found.words(None)
        complete = all(each.about["complete"] for each in built.solves)
        return ModesAnswer(
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


def _read(given: Mapping[str, Any], max_frequency: float | None) -> Scene:
    """A scene, with the end of its window where it gives none."""
    data = deepcopy(dict(given))
    if data["analysis"]["kind"] == "cea":
        data["analysis"].setdefault("max_frequency", max_frequency or 1.0)
    return read_scene(data)


def _end(scene: Scene) -> float:
    return float(scene.analysis.max_frequency)  # type: ignore[union-attr]
