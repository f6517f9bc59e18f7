"""Results as plain data for ``result.json``."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from cea.contact.interface import Interface
from cea.eigen.spectrum import Spectrum
from scenes.results.result import Result
from scenes.spec.plain import as_data

if TYPE_CHECKING:
    from cea.system.steady_state import ContactState, LoadStep, SteadySliding


def described_run(result: Result) -> dict[str, Any]:
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


def describe_modes(modes: Spectrum, growth_threshold: float | None) -> dict[str, Any]:
    """Eigenvalues with their errors, the window searched, verdicts, the unstable modes.

    ``mode`` is the number of a mode, from 1: entry ``mode - 1`` of the list ``eigenvalues``.
    """
    rows, window = modes.table(growth_threshold), modes.window
    bounded = np.zeros(len(rows), bool) if modes.bounded is None else modes.bounded
    unstable = [row for row in rows if row["verdict"] == "unstable"]
    same = ("residual", "condition", "uncertainty", "verdict", "rigid")
    return {
        "unstable_count": len(unstable),
        "unstable": [
            {
                **{"mode": row["mode"], "frequency": row["frequency"]},
                **{"growth": row["growth_rate"], "damping_ratio": row["damping_ratio"]},
            }
            for row in unstable
        ],
        "verdict": modes.verdict(growth_threshold),
        "hints": modes.hints,
        "window": asdict(window) | {"complete": window.complete, "evidence": window.evidence},
        "eigenvalues": [
            {
                **{name: row[name] for name in ("mode", "frequency", "damping_ratio")},
                **{"re": row["growth_rate"], "im": float(value.imag)},
                **{name: row[name] for name in same},
                "bounded": bool(cannot),
            }
            for row, value, cannot in zip(rows, modes.eigenvalues, bounded, strict=True)
        ],
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
    """A state of steady sliding as plain data, without fields over points."""
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
    return {
        "normal_force": state.normal_force,
        "friction_force": state.friction_force,
        "force_on_a": state.force_on_a.tolist(),
        "area": state.area,
        "closed_area": state.closed_area,
        "largest_pressure": float(state.pressure.max()),
        "largest_stiffness": float(state.stiffness.max()),
    }
