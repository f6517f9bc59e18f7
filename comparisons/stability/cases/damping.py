"""Damping and rotation, from next to nothing to critical."""

from collections.abc import Iterator
from functools import partial
from math import sqrt
from typing import Any

from comparisons.stability.parts.case import MESH, Case, Rows
from comparisons.stability.parts.problems import OfMap
from comparisons.stability.parts.references import carried, damped
from comparisons.stability.parts.scenes import (
    HELD_BELOW,
    Scene,
    body,
    boxes,
    changed,
    contact,
    layers,
    rectangle,
    scene,
)
from comparisons.stability.parts.ways import ALONE, PAIR

SUBJECT = "damping and rotation"
_UNDECIDED = (*MESH, "undecided")
"""Where errors of eigenvalues may hide a decay."""


def _with(data: Scene, damping: dict[str, Any], *bodies: str) -> Scene:
    """A scene with damping of some bodies, or of all."""
    changes = {f"bodies.{name}.damping": damping for name in bodies or data["bodies"]}
    return changed(data, {**changes, "analysis.min_growth": -3.0})


_FACTORS = {
    "contacts.interface.mu": (0.0, 0.5, 1.0),
    "bodies.upper.damping.alpha": (0.0, 0.25, 0.5),
    "bodies.lower.damping.beta": (0.0, 0.05, 0.1),
}


def _factors(alpha: float, beta: float, mu: float) -> Scene:
    data = _with(layers(p=10.0, mu=mu), {"alpha": alpha}, "upper")
    return _with(data, {"beta": beta}, "lower")


_STANDS = 0.0447
"""Rate (rad/s), for sqrt(E / rho) = 1 m/s, at which the backward wave of two diameters stands."""
_BETWEEN = 0.15
"""Kappa (1/s^2) between the waves of three and four diameters, likewise."""


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


def _rings(material: str, E: float, rho: float, parts: tuple[float, ...]) -> Iterator[Rows]:
    """Free rings at parts of the rate at which a wave stands: their decay is that at rest.

    The mesh leaves three digits of it. Rigid motions at rest in space decay by nothing: their sign
    is lost in rounding.
    """
    omega = sqrt(E / rho)
    geometry = {"shape": "ring", "inner_radius": 0.9, "outer_radius": 1.0}
    for words, damping, decay in _dampings(omega):
        window = {"kind": "cea", "max_frequency": 0.1 * omega, "min_growth": -decay}
        for part in parts:
            rate = part * _STANDS * omega
            rotation = {"rate": rate, "coriolis": False, "convective_stiffness": True}
            moving: Scene = {"rotation": rotation, "damping": damping}
            ring = body(geometry, (1, 24), degree=3, E=E, rho=rho, **moving)
            row = f"{material}, damped by {words}, {part:g} of the rate of a standing wave"
            may = (*MESH, "centrifugal-stresses", *(("undecided",) if part else ()))
            yield Rows(
                {row: scene({"ring": ring}, window)}, ALONE, carried, tolerance=1e-3, warnings=may
            )


def _ratio(ratio: float) -> Rows:
    """Layers between rollers, with friction; the ends of the modes looked at have the ratio."""
    damping = {"ratios": [ratio, ratio], "frequencies": [0.05, 0.6]}
    scenes = {
        f"ζ = {ratio:g}, both": _with(layers(p=10.0), damping),
        f"ζ = {ratio:g}, upper alone": _with(layers(p=10.0), damping, "upper"),
    }
    return Rows(scenes, PAIR, damped, warnings=_UNDECIDED if ratio == 1e-12 else MESH)


_EVERY = 1e3
"""Frequency (Hz) above all modes of these bodies."""


def _modal(modal: dict[str, Any], *bodies: str) -> Scene:
    return _with(layers(p=10.0), {"modal": modal}, *bodies)


def _square() -> Scene:
    """A square that contacts alone hold, at a base and at a wall: alone its modes come in pairs."""
    wall = body(rectangle((0.5, 1.0), (1.0, 0.0)), (2, 4), supports=[{"surface": "x_max"}])
    base = body(rectangle((1.0, 1.0), (0.0, -1.0)), (4, 4), supports=HELD_BELOW)
    upwards = {"vector": [0.0, 1.0]}
    data = scene(
        {"square": body(rectangle((1.0, 1.0)), (3, 3)), "base": base, "wall": wall},
        below=contact("square.y_min", "base.y_max", P=10.0),
        beside=contact("square.x_max", "wall.x_min", P=10.0, friction_direction_on_a=upwards),
    )
    return _with(data, {"modal": {"ratio": 0.05, "max_frequency": _EVERY}}, "square")


def _ring(rate: float, *, coriolis: bool, convective: bool) -> Scene:
    rotation = {"rate": rate, "coriolis": coriolis, "convective_stiffness": convective}
    geometry = {"shape": "ring", "inner_radius": 0.5, "outer_radius": 1.0}
    held = [{"surface": "inner"}]
    return scene({"ring": body(geometry, (2, 12), supports=held, rotation=rotation)})


def _boxes(sliding: Scene) -> Scene:
    top, bottom = [{"surface": "z_max"}], [{"surface": "z_min"}]
    sizes = {
        "upper": ([1.0, 0.8, 0.5], [0.3, 0.1, 0.0], (2, 2, 1), 0.5, top),
        "lower": ([2.0, 1.0, 1.0], [0.0, 0.0, -1.0], (2, 2, 1), 1.0, bottom),
    }
    return boxes(sizes, p=2.0, sliding={"pressure": 0.05} | sliding)


_SLIDING: dict[str, Scene] = {
    "v = 1e6": {"speed": 1e6},
    "v = 1": {"speed": 1.0},
    "v = 1e-6": {"speed": 1e-6},
    "v varies": {"speed": "0.01 + hypot(x, y)"},
    "μ' = -1e-9": {"speed": 1.0, "mu_slope": -1e-9},
    "μ' = -1": {"speed": 1.0, "mu_slope": -1.0},
    "μ' = 1": {"speed": 1.0, "mu_slope": 1.0},
    "μ' changes sign": {"speed": 1.0, "mu_slope": "x - 0.8"},
}

CASES = {
    "damped_maps": Case(
        "Maps of friction and damping by a reduced model",
        Rows(
            {
                f"α = {alpha:g} 1/s, β = {beta:g} s, μ = {mu:g}": _factors(alpha, beta, mu)
                for alpha, beta, mu in ((1e-9, 1e-12, 0.83), (3e-3, 1e-3, 0.3), (0.4, 0.07, 0.61))
            },
            PAIR,
            damped,
            problem=partial(OfMap, axes=_FACTORS),
        ),
    ),
    "damped_rotation": Case(
        "A free ring that rotates, heavily damped",
        *_rings("soft", 1.0, 1.0, (0.0, 1.0, 1.5)),
        *_rings("steel", 2e11, 7800.0, (1.5,)),
    ),
    "damping": Case(
        "Damping ratios 1e-12 to 1",
        *(_ratio(ratio) for ratio in (1e-12, 1e-6, 1e-2, 0.3, 1.0)),
    ),
    "modal_damping": Case(
        "Modal damping, ratios 1e-12 to 0.999",
        Rows(
            {
                **{
                    f"ζ = {ratio:g}, all modes": _modal({"ratio": ratio, "max_frequency": _EVERY})
                    for ratio in (1e-12, 1e-6, 1e-2, 0.3, 0.999)
                },
                "ζ = 0.01 up to 0.3 Hz": _modal({"ratio": 1e-2, "max_frequency": 0.3}),
            },
            PAIR,
            damped,
        ),
        Rows(
            {
                "a list to next to critical": _modal(
                    {"ratios": [0.999, 1e-12, 0.0, 0.5, 0.999999]}, "upper"
                )
            },
            PAIR,
            damped,
            warnings=_UNDECIDED,
        ),
        Rows(
            {
                "a table": _modal({"ratios": [0.9, 1e-6, 0.5], "frequencies": [0.2, 0.4, _EVERY]}),
                "a free square": _square(),
            },
            PAIR,
            damped,
        ),
    ),
    "rotation": Case(
        "A rotating ring, held at its inner rim",
        Rows(
            {
                f"Ω = {rate:g}, {'with' if coriolis else 'no'} Coriolis forces"
                f"{', convective stiffness' if convective else ''}": _ring(
                    rate, coriolis=coriolis, convective=convective
                )
                for rate in (1e-9, 1e-3, 0.1, 1.0, 5.0)
                for coriolis in (True, False)
                for convective in (False, True)
            },
            ALONE,
            damped,
            warnings=(*MESH, "centrifugal-stresses", "faster-than-waves"),
        ),
    ),
    "sliding_speed": Case(
        "Sliding speeds 1e-6 to 1e6, slopes of friction",
        Rows({words: _boxes(sliding) for words, sliding in _SLIDING.items()}, PAIR, damped),
    ),
}
