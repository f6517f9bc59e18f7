"""A heavily damped ring that rotates up to beyond the rate at which a wave stands still."""

from collections.abc import Iterator
from math import sqrt
from typing import Any

from comparisons.stability.parts.case import MESH, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import carried
from comparisons.stability.parts.scenes import Scene, body, scene
from comparisons.stability.parts.ways import ALONE

_STANDS = 0.0447
"""Rate (rad/s), for sqrt(E / rho) = 1 m/s, at which the backward wave of two diameters stands."""
_BETWEEN = 0.15
"""Kappa (1/s^2) between the waves of three and four diameters, likewise."""
_MATERIALS = {
    "soft": ((1.0, 1.0), (0.0, 1.0, 1.5)),
    "steel": ((2e11, 7800.0), (1.5,)),
}
"""E (N/m^2) and rho (kg/m^3); rates in parts of that at which the wave stands."""


def _dampings(omega: float) -> Iterator[tuple[str, dict[str, Any], float]]:
    """Words, damping, and a decay (1/s) that all waves of two and three diameters are below.

    Ratios of these are 0.2 to 0.8; omega is a unit of frequency (rad/s). Damping of the mass is in
    all, for rigid motions have double eigenvalues without.
    """
    alpha, beta, ratio = 0.05 * omega, 3.0 / omega, 0.5
    yield "α", {"alpha": 2 * alpha}, 2 * alpha
    decay = (alpha + beta * _BETWEEN * omega**2) / 2
    yield "α and β", {"alpha": alpha, "beta": beta}, decay
    modal = {"ratio": ratio, "max_frequency": 1e3 * omega}
    decay = alpha / 2 + ratio * sqrt(_BETWEEN) * omega
    yield "α and mode by mode", {"alpha": alpha, "modal": modal}, decay


def _ring(E: float, rho: float, rate: float, damping: dict[str, Any], decay: float) -> Scene:
    rotation = {"rate": rate, "coriolis": False, "convective_stiffness": True}
    geometry = {"shape": "ring", "inner_radius": 0.9, "outer_radius": 1.0}
    part = body(geometry, (1, 24), degree=3, E=E, rho=rho, rotation=rotation, damping=damping)
    window = {"max_frequency": 0.1 * sqrt(E / rho), "min_growth": -decay}
    return scene({"ring": part}, {"kind": "cea"} | window)


@case("A free ring that rotates, heavily damped", subject="damping and rotation")
def damped_rotation() -> Iterator[Run]:
    """Decay is that at rest, whatever the rate; the mesh leaves three digits of it.

    Rigid motions at rest in space decay by nothing: their sign is lost in rounding.
    """
    for material, ((E, rho), parts) in _MATERIALS.items():
        omega = sqrt(E / rho)
        for words, damping, decay in _dampings(omega):
            for part in parts:
                ring = _ring(E, rho, part * _STANDS * omega, damping, decay)
                row = f"{material}, damped by {words}, {part:g} of the rate of a standing wave"
                for way in ALONE:
                    data, lost = way.of(ring), ("undecided",) if part else ()
                    may = (*MESH, "centrifugal-stresses", *lost)
                    problem, true = OfScene(data), carried(data)
                    yield Run(row, way, problem, true, tolerance=1e-3, warnings=may)
