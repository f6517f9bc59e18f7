"""A sweep: the modes of a scene at some values of one field, and which of them belong together."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.eigen.matching import assign
from cea.errors import ConvergenceError, InputError
from comparisons.kit.run_warnings import Run, merged_warnings
from comparisons.kit.tables import Data
from scenes import Result
from scenes.results.record import record
from scenes.running.assembled import AssembledScene
from scenes.running.matrices import AssembledMatrices
from scenes.running.swept import means_several, parameters_meant, stiffnesses_meant
from scenes.spec.files import is_of_matrices
from scenes.spec.matrices import load_matrices
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

COMMAND = "sweep"
_NEAR = 0.02
"""Distance, relative to abs(lambda), up to which modes at neighbouring values are one curve."""
_MOST = 1000
"""Values of a sweep."""


Assembled = AssembledScene | AssembledMatrices
"""A scene that is solved at changed fields."""
Result = Result
"""What comes of it."""


@dataclass(frozen=True)
class Sweep:
    """What is swept.

    Parameters
    ----------
    scene
        Name of a scene, or its file.
    field
        Path of the field that is changed, e.g. ``parameters.Omega``; or a short name, or one with
        asterisks, of fields that change together (:func:`scenes.running.swept.parameters_meant`).
    start, stop
        Its first and its last value.
    count
        Number of values, evenly spaced.
    overrides
        Other fields, as ``--set`` takes them.
    data
        Folder of the files of a scene of matrices.
    """

    scene: str | Path
    field: str
    start: float
    stop: float
    count: int
    overrides: tuple[str, ...] = ()
    data: str | None = None

    def __post_init__(self) -> None:
        if not 2 <= self.count <= _MOST:
            raise InputError("points", self.count, f"2 to {_MOST}")
        for name, value in (("start", self.start), ("stop", self.stop)):
            if not np.isfinite(value):
                raise InputError(name, value, "a finite number")
        if self.start == self.stop:
            raise InputError("stop", self.stop, "another value than start")

    @property
    def values(self) -> list[float]:
        """The values of the field."""
        return np.linspace(self.start, self.stop, self.count).tolist()

    def assembled(self) -> Assembled:
        """The scene, assembled as it is, or at the first value of a field that is no parameter."""
        several = means_several(self.field)
        at_first = [*self.overrides, *([] if several else [f"{self.field}={self.start!r}"])]
        if is_of_matrices(self.scene):
            return AssembledMatrices(load_matrices(self.scene, at_first, self.data))
        if self.data is not None:
            raise InputError("data", self.data, "left out: a scene of bodies reads no matrices")
        try:
            scene = load_scene(self.scene, self.overrides)
        except SceneError:  # a field may be given by the sweep alone
            scene = load_scene(self.scene, at_first)
        stiffnesses_meant(scene.contacts, self.field)  # refuses p that is a field
        assembled = AssembledScene(scene)
        if several or self.field in assembled.driver.pencil.parameters:
            return assembled
        assembled.free()
        return AssembledScene(scene.change(self.field, self.start))

    def paths(self, assembled: Assembled) -> list[str]:
        """Paths of the fields that change together."""
        if not means_several(self.field):
            return [self.field]
        bonded: Sequence[str] = ()
        if isinstance(assembled, AssembledScene):
            p = stiffnesses_meant(assembled.scene.contacts, self.field)
            if p:
                return [f"contacts.{each}.p" for each in p]
            bonded = assembled.bonded
        pencil = assembled.driver.pencil
        try:
            return parameters_meant(pencil, self.field, bonded)
        except InputError as error:
            raise InputError(self.field, self.start, error.allowed) from error


def _solve(assembled: Assembled, paths: Sequence[str], value: float) -> Result:
    """Modes at a value of fields; of parameters as maps take them, factors on expressions."""
    values = dict.fromkeys(paths, value)
    if isinstance(assembled, AssembledScene) and set(paths) <= set(
        assembled.driver.pencil.parameters
    ):
        return assembled.modes_at(values)
    return assembled.modes(values)


def run_sweep(
    sweep: Sweep, progress: Callable[[str], None] = lambda _: None, why: str = ""
) -> dict[str, Any]:
    """Run a sweep; a value without an answer is kept beside the others, with the reason.

    Parameters
    ----------
    sweep
        What is swept.
    progress
        Called with each value as it begins.
    why
        Why each value is solved in full.

    Returns
    -------
    dict
        The record: ``field``, ``growth_threshold`` (1/s, None where it is relative), ``why`` where
        it was told, ``points`` with ``value``, ``failed`` (the reason, or "") and ``modes``, each
        with ``curve``, a number that modes of one curve share, ``re``, ``im``, ``uncertainty`` and
        ``verdict``; ``warnings`` are those of all values, merged
        (:func:`comparisons.kit.run_warnings.merged_warnings`).
    """
    begun = perf_counter()
    assembled = sweep.assembled()
    paths = sweep.paths(assembled)
    points: list[dict[str, Any]] = []
    runs: list[Run] = []
    curves = Curves()
    threshold = None
    for value in sweep.values:
        progress(f"{sweep.field} = {value:g}")
        try:
            result = _solve(assembled, paths, value)
        except ConvergenceError as error:
            points.append({"value": value, "failed": str(error), "modes": [], "verdict": ""})
            curves.interrupt()
            continue
        runs.append(({sweep.field: value}, [warning.plain() for warning in result.warnings]))
        threshold = result.analysis.growth_threshold
        points.append(_point(value, result, curves.follow(result.eigenvalues)))
    assembled.free()
    inputs = {
        "scene": str(sweep.scene),
        "field": sweep.field,
        "start": sweep.start,
        "stop": sweep.stop,
        "points": sweep.count,
        "set": list(sweep.overrides),
        "data": sweep.data,
    }
    data = {"field": sweep.field, "growth_threshold": threshold, "points": points} | (
        {"why": why} if why else {}
    )
    seconds = perf_counter() - begun
    warnings = merged_warnings(runs, f"values of {sweep.field}")
    return record(COMMAND, data, inputs=inputs, seconds=seconds, warnings=warnings)


def _point(value: float, result: Result, curves: Sequence[int]) -> dict[str, Any]:
    modes = [
        {
            "curve": curve,
            "re": float(eigenvalue.real),
            "im": float(eigenvalue.imag),
            "uncertainty": float(uncertainty),
            "verdict": verdict,
        }
        for curve, eigenvalue, uncertainty, verdict in zip(
            curves,
            result.eigenvalues,
            result.modes.growth_uncertainties,
            result.modes.verdicts(result.analysis.growth_threshold),
            strict=True,
        )
    ]
    return {"value": value, "failed": "", "modes": modes, "verdict": result.verdict}


class Curves:
    """Which modes at neighbouring values are one curve: the nearest to where it was going.

    Curves are for the eye. Where modes come nearer to each other than they move from one value to
    the next, a curve may go on as another.
    """

    def __init__(self) -> None:
        self._last: Complexes = np.empty(0, dtype=complex)
        self._before: Complexes = np.empty(0, dtype=complex)
        self._numbers: list[int] = []
        self._next = 0

    def follow(self, eigenvalues: Complexes) -> list[int]:
        """Numbers of the curves of eigenvalues at the next value, shape (n,)."""
        foreseen = np.where(np.isnan(self._before), self._last, 2 * self._last - self._before)
        numbers, before = [-1] * len(eigenvalues), np.full(len(eigenvalues), np.nan + 0j)
        if len(foreseen) and len(eigenvalues):
            sizes = np.maximum(np.abs(eigenvalues), np.abs(eigenvalues).max() * _NEAR)
            cost = np.abs(foreseen[:, None] - eigenvalues) / sizes
            for i, j in zip(*assign(cost, _NEAR), strict=True):
                numbers[j], before[j] = self._numbers[i], self._last[i]
        for j, number in enumerate(numbers):
            if number < 0:
                numbers[j] = self._next
                self._next += 1
        self._last, self._before, self._numbers = eigenvalues.copy(), before, numbers
        return numbers

    def interrupt(self) -> None:
        """End all curves: there is no answer at the next value."""
        self._last = self._before = np.empty(0, dtype=complex)
        self._numbers = []


def curves_of(data: Data) -> dict[int, dict[str, Any]]:
    """Modes of each curve along the sweep: arrays of value, growth (1/s), frequency (Hz)."""
    found: dict[int, list[tuple[float, float, float, str]]] = {}
    for point in data["points"]:
        for mode in point["modes"]:
            frequency = mode["im"] / (2 * np.pi)
            row = (point["value"], mode["re"], frequency, mode["verdict"])
            found.setdefault(mode["curve"], []).append(row)
    return {
        number: {
            "value": np.array([row[0] for row in rows]),
            "growth": np.array([row[1] for row in rows]),
            "frequency": np.array([row[2] for row in rows]),
            "unstable": np.array([row[3] == "unstable" for row in rows]),
        }
        for number, rows in found.items()
    }
