"""Records of runs, checked as they are read, and eigenvalues made of them again."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import BaseModel, TypeAdapter

from cea.eigen.spectrum import Spectrum, Window
from cea.errors import InputError, ResultWarning


class Record(BaseModel):
    """What made a record: command, inputs, versions and the machine."""

    command: str
    inputs: dict[str, Any]
    versions: dict[str, str]
    commit: str
    machine: dict[str, Any]
    seconds: float
    warnings: tuple[Any, ...]


class Eigenvalue(BaseModel):
    """One of the eigenvalues of a record, with its errors."""

    re: float
    im: float
    residual: float
    condition: float
    uncertainty: float
    bounded: bool = False


class SideStress(BaseModel):
    """Normal stress of one side of a contact in a record."""

    min: float
    max: float
    arc: list[float]
    sigma_n_along: list[float | None]


class Dofs(BaseModel):
    """Counts of unknowns in a record."""

    free: int


class RunRecord(Record):
    """The record of a run (`docs/result_json.md`): what is needed to open it as a result."""

    scene: dict[str, Any]
    dofs: Dofs
    timings: dict[str, float]
    skipped: dict[str, str]
    warnings: tuple[ResultWarning, ...]
    eigenvalues: list[Eigenvalue] | None = None
    window: Window | None = None
    stresses: dict[str, dict[str, SideStress]] | None = None


def checked_record[T: Record](kind: type[T], data: Mapping[str, Any]) -> T:
    """Plain data as a record: no text for numbers, no list for tables."""
    return TypeAdapter(kind).validate_json(json.dumps(data), strict=True)


def opened_modes(record: RunRecord) -> Spectrum:
    """Eigenvalues of a record with their errors."""
    if record.eigenvalues is None or record.window is None:
        raise InputError("scene.analysis.kind", "cea", "'static', as the data are")
    values = record.eigenvalues
    return Spectrum(
        np.array([complex(value.re, value.im) for value in values], dtype=complex),
        np.array([value.residual for value in values], dtype=float),
        np.array([value.condition for value in values], dtype=float),
        np.array([value.uncertainty for value in values], dtype=float),
        record.window,
        bounded=np.array([value.bounded for value in values], dtype=bool),
        warnings=record.warnings,
    )
