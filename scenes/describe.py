"""Results as plain data for ``result.json``: scenes as run, timings, eigenvalues, stresses."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from cea.contact.interface import Interface
from cea.eigen.spectrum import Spectrum, Window
from cea.system.contact_stresses import SideStress
from scenes.matrix_run import MatrixResult
from scenes.plain import as_data
from scenes.results import ModesResult, StaticResult
from scenes.steady import steady_data
from scenes.stored import record, write_record

RUN = "run"
"""Command that a record of a run names."""


def save_result(
    result: ModesResult | StaticResult | MatrixResult,
    file: str | Path,
    *,
    inputs: Mapping[str, Any] | None = None,
    data: Mapping[str, Any] | None = None,
) -> Path:
    """Write the record of a run, which :func:`scenes.opened.open_result` opens; collective.

    Parameters
    ----------
    result
        The run.
    file
        The file; rank 0 writes it.
    inputs
        What the run was asked for in words; by default the name of the scene.
    data
        More to be kept beside it.
    """
    path, described = Path(file), describe(result)
    seconds = described.pop("seconds")
    if result.comm.rank == 0:
        inputs = {"scene": result.scene.name} if inputs is None else inputs
        described |= data or {}
        told = [warning.plain() for warning in result.warnings]
        write_record(record(RUN, described, inputs=inputs, seconds=seconds, warnings=told), path)
    return path


def describe(result: ModesResult | StaticResult | MatrixResult) -> dict[str, Any]:
    """Everything about a run, plain data as :func:`scenes.stored.write_record` takes them.

    What was found comes first; `docs/result_json.md` says what every field is.
    """
    run = {
        "scene": as_data(result.scene),
        "dofs": {"free": result.dofs},
        "timings": dict(result.timer.seconds),
        "seconds": result.timer.total,
        "skipped": dict(result.skipped),
    }
    if isinstance(result, MatrixResult):
        run["matrices"] = {name: piece.plain() for name, piece in result.pieces.items()}
    else:
        run |= _of_bodies(result)
    if isinstance(result, StaticResult):
        return run | {
            "stresses": {
                name: {side: _stress(stress) for side, stress in sides.items()}
                for name, sides in result.stresses.items()
            }
        }
    found = describe_modes(result.modes, result.analysis.growth_threshold)
    return {"summary": result.summary} | found | run


def _of_bodies(result: ModesResult | StaticResult) -> dict[str, Any]:
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


def _stress(stress: SideStress) -> dict[str, Any]:
    return {
        "oscillation": stress.oscillation,
        "min": float(stress.sigma_n.min()),
        "max": float(stress.sigma_n.max()),
        "arc": stress.arc.tolist(),
        "sigma_n_along": [_number(v) for v in stress.sigma_n_along],
    }


def _interface(interface: Interface) -> dict[str, Any]:
    return {
        "points": len(interface.points),
        "area": interface.a.area,
        "status": dict(interface.statuses),
        "largest_distance": interface.largest_distance,
        "tolerance": interface.opposite.tolerance,
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
