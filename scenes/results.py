"""Results as plain data for ``result.json``: scenes as run, versions, timings, eigenvalues."""

import json
import platform
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from os import cpu_count
from pathlib import Path
from typing import Any

import numpy as np

from cea.contact.interface import Interface
from cea.eigen.modes import Modes
from scenes.run import SceneResult
from scenes.spec import ComplexEigenvalueAnalysis

_PACKAGES = {
    "dolfinx": "dolfinx-solver-real",
    "gmsh": "gmsh",
    "numpy": "numpy",
    "scipy": "scipy",
    "pyvista": "pyvista",
    "friction-cea": "friction-cea",
}


def describe(result: SceneResult) -> dict[str, Any]:
    """Everything about a run, ready for JSON."""
    scene = result.scene
    data: dict[str, Any] = {
        "scene": _in_json(asdict(scene)),
        "versions": versions(),
        "machine": machine(),
        "dofs": {
            "free": result.system.size,
            "bodies": {n: int(b.expansion.getSize()[1]) for n, b in result.system.bodies.items()},
        },
        "timings": dict(result.timer.seconds),
        "seconds": result.timer.total,
        "skipped": dict(result.skipped),
        "contacts": {name: _interface(i) for name, i in result.interfaces.items()},
    }
    if result.modes is not None and isinstance(scene.analysis, ComplexEigenvalueAnalysis):
        data |= describe_modes(result.modes, scene.analysis.growth_threshold)
    if result.stresses is not None:
        data["stresses"] = {
            name: {
                side: {
                    "oscillation": stress.oscillation,
                    "min": float(stress.sigma_n.min()),
                    "max": float(stress.sigma_n.max()),
                    "arc": stress.arc.tolist(),
                    "sigma_n_along": [_number(v) for v in stress.sigma_n_along],
                }
                for side, stress in sides.items()
            }
            for name, sides in result.stresses.items()
        }
    return data


def describe_modes(modes: Modes, growth_threshold: float) -> dict[str, Any]:
    """Eigenvalues with their errors, the window searched, the unstable modes."""
    unstable = modes.unstable(growth_threshold)
    return {
        "eigenvalues": [
            {
                "re": float(value.real),
                "im": float(value.imag),
                "residual": float(residual),
                "condition": float(condition),
            }
            for value, residual, condition in zip(
                modes.eigenvalues, modes.residuals, modes.conditions, strict=True
            )
        ],
        "window": asdict(modes.window) | {"evidence": modes.window.evidence},
        "unstable": [
            {"mode": int(i), "frequency": float(f), "growth": float(g)}
            for i, f, g in zip(
                np.flatnonzero(unstable),
                modes.frequencies[unstable],
                modes.growth_rates[unstable],
                strict=True,
            )
        ],
    }


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that matter for numbers."""
    from cea.petsc import PETSc, SLEPc

    found = {"python": platform.python_version()}
    for name, package in _PACKAGES.items():
        try:
            found[name] = version(package)
        except PackageNotFoundError:
            found[name] = "not installed as a package"
    for name, system in (("petsc", PETSc.Sys), ("slepc", SLEPc.Sys)):
        found[name] = ".".join(map(str, system.getVersion()))
    return found


def machine() -> dict[str, Any]:
    """Processor count and kind."""
    return {"cpus": cpu_count(), "machine": platform.machine(), "system": platform.system()}


def write_json(data: Mapping[str, Any], file: Path) -> None:
    """Write a result, making its folder."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n")


def _interface(interface: Interface) -> dict[str, Any]:
    return {
        "points": len(interface.points),
        "area": interface.a.area,
        "status": dict(interface.statuses),
        "largest_distance": interface.largest_distance,
        "tolerance": interface.opposite.tolerance,
    }


def _in_json(value: Any) -> Any:
    """Plain data in which infinity, which JSON has no number for, is the text ``inf``."""
    if isinstance(value, dict):
        return {key: _in_json(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_in_json(part) for part in value]
    return "inf" if isinstance(value, float) and value == float("inf") else value


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
