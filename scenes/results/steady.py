"""A state of steady sliding as plain data, and as lines for people."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cea.system.steady_state import ContactState, LoadStep, SteadySliding


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
            "margin": step.state.margin,
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


def steady_lines(data: Mapping[str, Any]) -> list[str]:
    """Lines for people of :func:`steady_data`: half passes in each load step, and at last."""
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
