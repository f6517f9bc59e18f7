"""Results as plain data for ``result.json``, and eigenvalues made of such data again."""

from dataclasses import asdict
from typing import Any

import numpy as np

from cea.contact.interface import Interface
from cea.eigen.spectrum import Spectrum, Window
from scenes.results.result import Result
from scenes.results.steady import steady_data
from scenes.spec.plain import as_data


def described_run(result: Result) -> dict[str, Any]:
    """What every run has: the scene as run, unknowns, seconds, contact points, forces."""
    run = {
        "scene": as_data(result.scene),
        "dofs": {"free": result.dofs},
        "timings": dict(result.timer.seconds),
        "seconds": result.timer.total,
        "skipped": dict(result.skipped),
    }
    if result.pieces:
        return run | {"matrices": {name: piece.plain() for name, piece in result.pieces.items()}}
    return run | _of_bodies(result)


def _of_bodies(result: Result) -> dict[str, Any]:
    """What runs of bodies have, and those of matrices have not."""
    bodies = {n: int(b.expansion.getSize()[1]) for n, b in result.bodies.items()}
    data: dict[str, Any] = {
        "dofs": {"free": result.dofs, "bodies": bodies},
        "contacts": {name: _interface(i) for name, i in result.interfaces.items()},
    }
    if result.system.steady is not None:
        data["steady_sliding"] = steady_data(result.system.steady)
    if result.reactions:
        data["reactions"] = {name: force.tolist() for name, force in result.reactions.items()}
    return data


def describe_modes(modes: Spectrum, growth_threshold: float | None) -> dict[str, Any]:
    """Eigenvalues with their errors, the window searched, verdicts, the unstable modes.

    ``mode`` is the number of a mode, from 1: entry ``mode - 1`` of the list ``eigenvalues``.
    """
    rows = modes.table(growth_threshold)
    bounded = np.zeros(len(rows), bool) if modes.bounded is None else modes.bounded
    return {
        "unstable_count": sum(row["verdict"] == "unstable" for row in rows),
        "unstable": [
            {
                "mode": row["mode"],
                "frequency": row["frequency"],
                "growth": row["growth_rate"],
                "damping_ratio": row["damping_ratio"],
            }
            for row in rows
            if row["verdict"] == "unstable"
        ],
        "verdict": modes.verdict(growth_threshold),
        "hints": modes.hints,
        "window": _window(modes.window),
        "eigenvalues": [
            {
                "mode": row["mode"],
                "frequency": row["frequency"],
                "damping_ratio": row["damping_ratio"],
                "re": row["growth_rate"],
                "im": float(value.imag),
                "residual": row["residual"],
                "condition": row["condition"],
                "uncertainty": row["uncertainty"],
                "verdict": row["verdict"],
                "rigid": row["rigid"],
                "bounded": bool(cannot),
            }
            for row, value, cannot in zip(rows, modes.eigenvalues, bounded, strict=True)
        ],
    }


def _window(window: Window) -> dict[str, Any]:
    """Its fields, and what is claimed of it."""
    return asdict(window) | {"complete": window.complete, "evidence": window.evidence}


def _interface(interface: Interface) -> dict[str, Any]:
    return {
        "points": len(interface.points),
        "area": interface.a.area,
        "status": dict(interface.statuses),
        "largest_distance": interface.largest_distance,
        "tolerance": interface.opposite.tolerance,
    }
