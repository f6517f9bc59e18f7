"""Stored results opened again: modes, stresses, or the data of any other command."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NotRequired, TypedDict

import numpy as np
from pydantic import TypeAdapter, ValidationError

from cea.arrays import Floats
from cea.eigen.quadratic_window import QuadraticWindow
from cea.eigen.spectrum import Spectrum, Window
from cea.errors import InputError
from cea.warned import ResultWarning
from scenes.spec.problems import faults_told_by
from scenes.spec.matrices import MatrixScene, read_matrix_scene
from scenes.results.of_modes import OfModes
from scenes.results.of_stresses import Extremes, stress_lines, stress_rows
from scenes.spec.reading import Scene, read_scene
from scenes.results.record import PROVENANCE, read_record


@dataclass(frozen=True)
class StoredResult:
    """What a command computed, and what made it.

    Parameters
    ----------
    command, inputs
        The command and what it was given.
    versions, commit, machine
        What it ran on.
    seconds
        How long it took.
    warnings
        What a reader must know.
    data
        What it computed, plain data.
    """

    command: str
    inputs: Mapping[str, Any]
    versions: Mapping[str, str]
    commit: str
    machine: Mapping[str, Any]
    seconds: float
    warnings: tuple[Mapping[str, Any], ...]
    data: Mapping[str, Any]

    def __repr__(self) -> str:
        return f"{self.command}, {self.commit}: {', '.join(self.data)}"


@dataclass(frozen=True)
class _StoredRun(StoredResult):
    """What every stored run has.

    Parameters
    ----------
    scene
        The scene as run.
    """

    scene: Scene | MatrixScene

    @property
    def dofs(self) -> int:
        """Free dofs."""
        return int(self.data["dofs"]["free"])

    @property
    def timings(self) -> Mapping[str, float]:
        """Seconds by stage."""
        return self.data["timings"]

    @property
    def skipped(self) -> Mapping[str, str]:
        """What the scene did not need, with the reason."""
        return self.data["skipped"]


@dataclass(frozen=True)
class StoredModes(_StoredRun, OfModes):
    """Modes of a complex eigenvalue analysis, without their shapes.

    Parameters
    ----------
    modes
        Eigenvalues, their errors and the window that was searched.
    """

    modes: Spectrum

    __repr__ = OfModes.__repr__

    def steady_lines(self) -> list[str]:
        """What the contacts carry in steady sliding, a line for each half pass."""
        from scenes.running.steady import steady_lines  # brings PETSc, which opening a file does not need

        steady = self.data.get("steady_sliding")
        return [] if steady is None else steady_lines(steady)


@dataclass(frozen=True)
class StoredStress:
    """Normal stress of one side of a contact (N/m^2).

    Parameters
    ----------
    min, max, oscillation
        Extremes over the surface, and their difference.
    arc
        Distances (m) along the diagonal of side a, shape (m,).
    sigma_n_along
        Stress on that line, shape (m,); NaN where the line leaves the surface.
    """

    min: float
    max: float
    oscillation: float
    arc: Floats
    sigma_n_along: Floats


@dataclass(frozen=True)
class StoredStatic(_StoredRun):
    """Contact stresses of a static analysis.

    Parameters
    ----------
    stresses
        By contact, then side "a" or "b".
    """

    stresses: Mapping[str, Mapping[str, StoredStress]]

    def table(self) -> list[dict[str, Any]]:
        """A row for each side of each contact, as :meth:`scenes.results.result.StaticResult.table`."""
        return stress_rows(
            {
                name: {side: Extremes(s.min, s.max, s.oscillation) for side, s in sides.items()}
                for name, sides in self.stresses.items()
            }
        )

    def __repr__(self) -> str:
        rows = stress_lines(self.table())
        return "\n".join([f"{self.scene.name}: static analysis", *rows])


def open_result(file: str | Path) -> StoredModes | StoredStatic | StoredResult:
    """Open what a command stored.

    Parameters
    ----------
    file
        A ``result.json``, or any other record of a command; compressed where it ends in ``.gz``.

    Returns
    -------
    StoredResult
        Of a run a :class:`StoredModes` or a :class:`StoredStatic`.

    Raises
    ------
    InputError
        When there is no such file, or it is no record.
    """
    data = read_record(file)
    missing = [name for name in PROVENANCE if name not in data]
    if missing:
        raise InputError("file", str(file), f"a stored result; {', '.join(missing)} not in it")
    try:
        common = _checked(_COMMON, {name: data.pop(name) for name in PROVENANCE})
        return _typed({**common, "data": data}, data)
    except ValidationError as error:
        first = faults_told_by(error)[0]
        raise InputError("file", str(file), f"a stored result; broken at {first}") from error


class _Common(TypedDict):
    """What every record has, as :mod:`scenes.results.record` says."""

    command: str
    inputs: dict[str, Any]
    versions: dict[str, str]
    commit: str
    machine: dict[str, Any]
    seconds: float
    warnings: tuple[dict[str, Any], ...]


class _Dofs(TypedDict):
    free: int


class _Run(TypedDict):
    """What every run has, as :func:`scenes.results.describe.describe` says."""

    scene: dict[str, Any]
    dofs: _Dofs
    timings: dict[str, float]
    skipped: dict[str, str]


class _Eigenvalue(TypedDict):
    re: float
    im: float
    residual: float
    condition: float
    uncertainty: float
    bounded: NotRequired[bool]


class _Modes(_Run):
    eigenvalues: list[_Eigenvalue]
    window: QuadraticWindow | Window


class _Stress(TypedDict):
    min: float
    max: float
    oscillation: float
    arc: list[float]
    sigma_n_along: list[float | None]


class _Static(_Run):
    stresses: dict[str, dict[str, _Stress]]


_COMMON, _MODES, _STATIC = TypeAdapter(_Common), TypeAdapter(_Modes), TypeAdapter(_Static)
_WARNING = TypeAdapter(ResultWarning)


def _checked[T](kind: TypeAdapter[T], data: Any) -> T:
    """Plain data as what they should be: no text for numbers, no list for tables."""
    return kind.validate_json(json.dumps(data), strict=True)


def _typed(common: dict[str, Any], data: dict[str, Any]) -> StoredResult:
    """The result of the kind that its data say."""
    if "eigenvalues" in data and "scene" in data:
        modes = _spectrum(_checked(_MODES, data), common["warnings"])
        return StoredModes(**common, scene=_scene(data, "cea"), modes=modes)
    if "stresses" in data and "scene" in data:
        stresses = {
            name: {side: _stress(stress) for side, stress in sides.items()}
            for name, sides in _checked(_STATIC, data)["stresses"].items()
        }
        return StoredStatic(**common, scene=_scene(data, "static"), stresses=stresses)
    return StoredResult(**common)


def _scene(data: Mapping[str, Any], kind: str) -> Scene | MatrixScene:
    """The scene of a run, whose analysis must be of the kind of its data."""
    of_matrices = "files" in data["scene"]
    scene = read_matrix_scene(data["scene"]) if of_matrices else read_scene(data["scene"])
    if scene.analysis.kind != kind:
        raise InputError("scene.analysis.kind", scene.analysis.kind, f"{kind!r}, as the data are")
    return scene


def _spectrum(data: _Modes, warnings: Iterable[Mapping[str, Any]]) -> Spectrum:
    re, im, residual, condition, uncertainty = (
        np.array([value[name] for value in data["eigenvalues"]], dtype=float)
        for name in ("re", "im", "residual", "condition", "uncertainty")
    )
    told = tuple(_checked(_WARNING, warning) for warning in warnings)
    bounded = np.array([value.get("bounded", False) for value in data["eigenvalues"]], dtype=bool)
    return Spectrum(
        *(re + 1j * im, residual, condition, uncertainty, data["window"]),
        bounded=bounded,
        warnings=told,
    )


def _stress(stress: _Stress) -> StoredStress:
    arrays = [np.array(stress[name], dtype=float) for name in ("arc", "sigma_n_along")]
    return StoredStress(stress["min"], stress["max"], stress["oscillation"], *arrays)
