"""Stored results opened again: modes, stresses, or the data of any other command."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from cea.body import Floats
from cea.eigen.spectrum import Spectrum, Window
from cea.errors import InputError
from cea.warned import ResultWarning
from scenes.of_modes import OfModes
from scenes.read import Scene, read_scene
from scenes.stored import PROVENANCE, read_record


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

    scene: Scene

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
class StoredModes(OfModes, _StoredRun):
    """Modes of a complex eigenvalue analysis, without their shapes.

    Parameters
    ----------
    modes
        Eigenvalues, their errors and the window that was searched.
    """

    modes: Spectrum

    __repr__ = OfModes.__repr__


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
    common = {name: data.pop(name) for name in PROVENANCE} | {"data": data}
    common["warnings"] = tuple(common["warnings"])
    try:
        return _typed(common, data)
    except (KeyError, TypeError) as error:
        raise InputError("file", str(file), f"a stored result; broken at {error}") from error


def _typed(common: dict[str, Any], data: dict[str, Any]) -> StoredResult:
    """The result of the kind that its data say."""
    if "eigenvalues" in data and "scene" in data:
        modes = _spectrum(data, common["warnings"])
        return StoredModes(**common, scene=read_scene(data["scene"]), modes=modes)
    if "stresses" in data and "scene" in data:
        stresses = {
            name: {side: _stress(stress) for side, stress in sides.items()}
            for name, sides in data["stresses"].items()
        }
        return StoredStatic(**common, scene=read_scene(data["scene"]), stresses=stresses)
    return StoredResult(**common)


def _spectrum(data: Mapping[str, Any], warnings: Iterable[Mapping[str, Any]]) -> Spectrum:
    columns = {
        name: np.array([value[name] for value in data["eigenvalues"]], dtype=float)
        for name in ("re", "im", "residual", "condition", "uncertainty")
    }
    window = Window(**{field.name: data["window"][field.name] for field in fields(Window)})
    eigenvalues = columns["re"] + 1j * columns["im"]
    told = tuple(ResultWarning(**warning) for warning in warnings)
    return Spectrum(
        eigenvalues,
        residuals=columns["residual"],
        conditions=columns["condition"],
        growth_uncertainties=columns["uncertainty"],
        window=window,
        warnings=told,
    )


def _stress(stress: Mapping[str, Any]) -> StoredStress:
    arrays = {name: np.array(stress[name], dtype=float) for name in ("arc", "sigma_n_along")}
    return StoredStress(stress["min"], stress["max"], stress["oscillation"], **arrays)
