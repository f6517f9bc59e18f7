"""Conversion of results to the plain data of records."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from cea.contact.interface import Interface
from cea.eigen.spectrum import Spectrum
from scenes.spec.contact import B_ON_A
from scenes.spec.plain import plain_data

if TYPE_CHECKING:
    from cea.system.steady_state import ContactState, LoadStep, SteadySliding


def described(result: Any) -> dict[str, Any]:
    """Return the data of a result for its record; `docs/result_json.md` describes the fields."""
    if result.spectrum is None:
        return _described_run(result) | {"stresses": _described_stresses(result.stresses)}
    found = _described_modes(result.modes, result.analysis.growth_threshold)
    return {"summary": result.summary} | found | _described_run(result)


def _described_stresses(stresses: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    found: dict[str, dict[str, Any]] = {name: {} for name in stresses}
    for name, sides in stresses.items():
        for side, stress in sides.items():
            along = [x if np.isfinite(x) else None for x in stress.sigma_n_along.tolist()]
            numbers = _picked(stress, "oscillation", "min", "max", "arc")
            found[name][side] = numbers | {"sigma_n_along": along}
    return found


def _picked(of: Any, *names: str) -> dict[str, Any]:
    """Return attributes by name, with arrays as lists."""
    values = {name: getattr(of, name) for name in names}
    return {n: v.tolist() if isinstance(v, np.ndarray) else v for n, v in values.items()}


def _described_run(result: Any) -> dict[str, Any]:
    """Return the data that every run has: scene, unknowns, times, contact points, reactions."""
    data: dict[str, Any] = {
        "scene": plain_data(result.scene),
        "dofs": {"free": result.dofs},
        "timings": dict(result.timer.seconds),
        "seconds": result.timer.total,
        "skipped": dict(result.skipped),
    }
    if result.pieces:
        facts, pieces = ("size", "entries", "symmetry", "asymmetry"), result.pieces.items()
        return data | {"matrices": {name: _picked(piece, *facts) for name, piece in pieces}}
    data["dofs"]["bodies"] = {n: int(b.expansion.getSize()[1]) for n, b in result.bodies.items()}
    data["contacts"] = {name: _interface(each) for name, each in result.interfaces.items()}
    if result.system.steady is not None:
        data["steady_sliding"] = _steady_data(result.system.steady)
    if result.reactions:
        data["reactions"] = {name: force.tolist() for name, force in result.reactions.items()}
    return data


def _interface(interface: Interface) -> dict[str, Any]:
    return {
        "points": len(interface.points),
        "area": interface.a.area,
        "status": dict(interface.statuses),
        "largest_distance": interface.largest_distance,
        "tolerance": interface.opposite.tolerance,
    }


def _described_modes(modes: Spectrum, growth_threshold: float | None) -> dict[str, Any]:
    """Return eigenvalues with their errors and verdicts, the window, and the unstable modes.

    ``mode`` is the number of a mode, from 1: entry ``mode - 1`` of the list ``eigenvalues``.
    """
    window, values = modes.window, []
    bounded = np.zeros(len(modes), bool) if modes.bounded is None else modes.bounded
    rows = zip(modes.table(growth_threshold), modes.eigenvalues.imag, bounded, strict=True)
    same = ("residual", "condition", "uncertainty", "verdict", "rigid")
    for row, im, cannot in rows:
        value = {name: row[name] for name in ("mode", "frequency", "damping_ratio")}
        value |= {"re": row["growth_rate"], "im": float(im)} | {name: row[name] for name in same}
        values.append(value | {"bounded": bool(cannot)})
    grow = [value for value in values if value["verdict"] == "unstable"]
    names = {"mode": "mode", "frequency": "frequency", "growth": "re"}
    names["damping_ratio"] = "damping_ratio"
    return {
        "unstable_count": len(grow),
        "unstable": [{name: value[own] for name, own in names.items()} for value in grow],
        "verdict": modes.verdict(growth_threshold),
        "hints": modes.window.hints,
        "window": asdict(window) | _picked(window, "complete", "evidence"),
        "eigenvalues": values,
    }


def _steady_data(steady: "SteadySliding") -> dict[str, Any]:
    """Return the data of a state of steady sliding, without fields at points."""
    return {
        **_picked(steady, "uncertainty", "residual", "iterations"),
        "path": [_step_data(step) for step in steady.path],
        "contacts": {name: _contact_data(state) for name, state in steady.contacts.items()},
        "uniqueness": steady.uniqueness and _picked(steady.uniqueness, "parity", "margin"),
    }


def _step_data(step: "LoadStep") -> dict[str, Any]:
    data = {"load": step.factor, **_picked(step, "residuals", "closed", "parity")}
    if step.displacement is None:
        return data
    contacts = {name: _contact_data(state) for name, state in step.contacts.items()}
    return data | {"iterations": len(step.lengths), "contacts": contacts}


def _contact_data(state: "ContactState") -> dict[str, Any]:
    names = ("normal_force", "friction_force", "area", "closed_area", "force_on_a")
    largest = {"pressure": state.pressure, "stiffness": state.stiffness}
    return _picked(state, *names) | {f"largest_{n}": float(v.max()) for n, v in largest.items()}


def steady_lines(data: Mapping[str, Any]) -> list[str]:
    """Return lines about steady sliding from its record: half passes at each step and finally."""
    lines = [
        f"{step['load']:.4g} of the load, {_line(name, step)}, {step['iterations']} Newton steps"
        for step in data["path"]
        for name in step.get("contacts", {})
    ]
    return lines + [_line(name, data) for name in data["contacts"]]


def _line(name: str, state: Mapping[str, Any]) -> str:
    """Return the line of a contact, or of half of a full pass, which carries half the pressure."""
    contacts = state["contacts"]
    contact, first = contacts[name], name.removesuffix(B_ON_A)
    half = f" (half of a full pass of {first})" if first + B_ON_A in contacts else ""
    closed = contact["closed_area"] / contact["area"]
    return (
        f"steady sliding, {name}{half}: normal force {contact['normal_force']:.6g} N, friction "
        f"{contact['friction_force']:.6g} N, {100 * closed:.3g} % of the area closed, pressure to "
        f"{contact['largest_pressure']:.6g} N/m^2"
    )
