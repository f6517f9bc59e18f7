"""Results as the plain data of their records, and the data of records as results again."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import BaseModel, TypeAdapter

from cea.contact.interface import Interface
from cea.eigen.spectrum import Spectrum, Window
from cea.errors import InputError, ResultWarning
from scenes.spec.plain import as_data

if TYPE_CHECKING:
    from cea.system.contact_stresses import NormalStress
    from cea.system.steady_state import ContactState, LoadStep, SteadySliding


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
    """What is read again of an eigenvalue."""

    re: float
    im: float
    residual: float
    condition: float
    uncertainty: float
    bounded: bool = False


class SideStress(BaseModel):
    """Normal stress of one side of a contact."""

    min: float
    max: float
    arc: list[float]
    sigma_n_along: list[float | None]


class Dofs(BaseModel):
    """Counts of unknowns."""

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


def opened(record: RunRecord, kind: str) -> dict[str, Any]:
    """Eigenvalues or stresses from the record of a kind of analysis, as fields of a result."""
    if record.stresses is not None and kind == "static":
        return {"stresses": {n: _opened_sides(sides) for n, sides in record.stresses.items()}}
    if record.eigenvalues is None or record.window is None or kind == "static":
        allowed = "'cea'" if record.eigenvalues is not None else "'static'"
        raise InputError("scene.analysis.kind", kind, f"{allowed}, as the data are")
    columns = [
        np.array([getattr(value, name) for value in record.eigenvalues], dtype=float)
        for name in ("re", "im", "residual", "condition", "uncertainty")
    ]
    re, im, residuals, conditions, uncertainties = columns
    spectrum = Spectrum(
        re + 1j * im,
        residuals,
        conditions,
        uncertainties,
        record.window,
        bounded=np.array([value.bounded for value in record.eigenvalues], dtype=bool),
        warnings=record.warnings,
    )
    return {"spectrum": spectrum}


def _opened_sides(sides: Mapping[str, SideStress]) -> dict[str, "NormalStress"]:
    """Contact stresses without those at the points of the surfaces."""
    from cea.system.contact_stresses import NormalStress

    return {
        side: NormalStress(
            stress.min,
            stress.max,
            np.array(stress.arc),
            np.array(stress.sigma_n_along, dtype=float),
        )
        for side, stress in sides.items()
    }


def described(result: Any) -> dict[str, Any]:
    """What the record of a result holds; `docs/result_json.md` says what every field is."""
    if result.spectrum is None:
        stresses = {name: _described_sides(sides) for name, sides in result.stresses.items()}
        return _described_run(result) | {"stresses": stresses}
    found = _described_modes(result.modes, result.analysis.growth_threshold)
    return {"summary": result.summary} | found | _described_run(result)


def _described_sides(sides: Mapping[str, "NormalStress"]) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for side, stress in sides.items():
        numbers = {name: getattr(stress, name) for name in ("oscillation", "min", "max")}
        along = [x if np.isfinite(x) else None for x in stress.sigma_n_along.tolist()]
        found[side] = numbers | {"arc": stress.arc.tolist(), "sigma_n_along": along}
    return found


def _described_run(result: Any) -> dict[str, Any]:
    """What every run has: the scene as run, unknowns, seconds, contact points, forces."""
    data: dict[str, Any] = {
        "scene": as_data(result.scene),
        "dofs": {"free": result.dofs},
        "timings": dict(result.timer.seconds),
        "seconds": result.timer.total,
        "skipped": dict(result.skipped),
    }
    if result.pieces:
        return data | {"matrices": {name: piece.plain() for name, piece in result.pieces.items()}}
    data["dofs"]["bodies"] = {n: int(b.expansion.getSize()[1]) for n, b in result.bodies.items()}
    data["contacts"] = {name: _interface(each) for name, each in result.interfaces.items()}
    if result.system.steady is not None:
        data["steady_sliding"] = steady_data(result.system.steady)
    if result.reactions:
        data["reactions"] = {name: force.tolist() for name, force in result.reactions.items()}
    return data


def _described_modes(modes: Spectrum, growth_threshold: float | None) -> dict[str, Any]:
    """Eigenvalues with their errors, the window searched, verdicts, the unstable modes.

    ``mode`` is the number of a mode, from 1: entry ``mode - 1`` of the list ``eigenvalues``.
    """
    window, values = modes.window, []
    bounded = np.zeros(len(modes), bool) if modes.bounded is None else modes.bounded
    rows = zip(modes.table(growth_threshold), modes.eigenvalues, bounded, strict=True)
    for row, eigenvalue, cannot in rows:
        value = {name: row[name] for name in ("mode", "frequency", "damping_ratio")}
        value |= {"re": row["growth_rate"], "im": float(eigenvalue.imag)}
        same = ("residual", "condition", "uncertainty", "verdict", "rigid")
        values.append(value | {name: row[name] for name in same} | {"bounded": bool(cannot)})
    unstable = [
        {"mode": each["mode"], "frequency": each["frequency"]}
        | {"growth": each["re"], "damping_ratio": each["damping_ratio"]}
        for each in values
        if each["verdict"] == "unstable"
    ]
    return {
        "unstable_count": len(unstable),
        "unstable": unstable,
        "verdict": modes.verdict(growth_threshold),
        "hints": modes.window.hints,
        "window": asdict(window) | {"complete": window.complete, "evidence": window.evidence},
        "eigenvalues": values,
    }


def _interface(interface: Interface) -> dict[str, Any]:
    return {
        "points": len(interface.points),
        "area": interface.a.area,
        "status": dict(interface.statuses),
        "largest_distance": interface.largest_distance,
        "tolerance": interface.opposite.tolerance,
    }


def steady_data(steady: "SteadySliding") -> dict[str, Any]:
    """A state of steady sliding, without fields over points."""
    unique = steady.uniqueness
    return {
        "uncertainty": steady.uncertainty,
        "residual": steady.residual,
        "iterations": steady.iterations,
        "path": [_step_data(step) for step in steady.path],
        "contacts": {name: _contact_data(state) for name, state in steady.contacts.items()},
        "uniqueness": unique and {"parity": unique.parity, "margin": unique.margin},
    }


def _step_data(step: "LoadStep") -> dict[str, Any]:
    data: dict[str, Any] = {
        "load": step.factor,
        "residuals": list(step.residuals),
        "closed": list(step.closed),
        "parity": step.parity,
    }
    if step.state is not None:
        data |= {
            "iterations": len(step.lengths),
            "contacts": {name: _contact_data(s) for name, s in step.state.contacts.items()},
        }
    return data


def _contact_data(state: "ContactState") -> dict[str, Any]:
    numbers = ("normal_force", "friction_force", "area", "closed_area")
    return {
        **{name: getattr(state, name) for name in numbers},
        "force_on_a": state.force_on_a.tolist(),
        "largest_pressure": float(state.pressure.max()),
        "largest_stiffness": float(state.stiffness.max()),
    }


def steady_lines(data: Mapping[str, Any]) -> list[str]:
    """Lines of a state as its record has it: half passes in each load step, and at last."""
    steps = [
        f"{step['load']:.4g} of the load, {_line(name, contact)}, {step['iterations']} Newton steps"
        for step in data["path"]
        for name, contact in step.get("contacts", {}).items()
    ]
    return steps + [_line(name, contact) for name, contact in data["contacts"].items()]


def _line(name: str, contact: Mapping[str, Any]) -> str:
    closed = 100 * contact["closed_area"] / contact["area"]
    return (
        f"steady sliding, {name}: normal force {contact['normal_force']:.6g} N, friction "
        f"{contact['friction_force']:.6g} N, {closed:.3g} % of the area closed, pressure to "
        f"{contact['largest_pressure']:.6g} N/m^2"
    )
