"""Cases of loads, damping and rotation, from near zero to critical."""

from collections.abc import Iterator
from functools import partial
from math import sqrt
from typing import Any

from scipy.optimize import brentq

from comparisons.stability.case import Runs, carried, refused, runs
from comparisons.stability.problems import of_map
from comparisons.stability.scenes import (
    Scene,
    base,
    body,
    changed,
    contact,
    layers,
    pressed_layers,
    rectangle,
    ring,
    scene,
    stacked,
    unequal_boxes,
)
from comparisons.stability.ways import ALONE, FEW, PAIR, UNIFORM, chosen

_ALLOWED = ("over-constrained", "under-sampled", "short-modes", "point-rule")
"""Warnings that runs under load may give."""
_OPENS = "the load opens the contact"
_PULLED = chosen(UNIFORM, "GPTS, penalty", "mortar, penalty")
_PULLING = pressed_layers(-1e-3, c_n=1.0, m_n=2.0)


def _slope(m: float, pressure: float, c: float) -> float:
    """Contact stiffness p of layers between rollers that a pressure closes uniformly."""
    return m * c * (pressure / c) ** ((m - 1) / m)


def steady_sliding() -> Runs:
    """Normal compliance: m_n from 1 to 5, loads from 1e-12, c_n to nearly rigid."""
    for m, pressure, c in (
        (1.0, 1e-3, 1.0),
        (2.0, 1e-3, 10.0),
        (3.3, 1e-3, 1e4),
        (5.0, 1e-3, 1e8),
        (2.0, 1e-12, 1e4),
        (5.0, 1e-10, 1e30),
        (2.0, 1e-3, 1e9),
    ):
        p, data = _slope(m, pressure, c), pressed_layers(pressure, c_n=c, m_n=m)
        rows = {f"m_n = {m:g}, pressure {pressure:.0e}, p = {p:.0e}": data}
        may, known = "accurate" if p < 1e5 else "honest", pressed_layers(p=p)  # beside E = 1
        yield from runs(rows, UNIFORM, instead=known, expected=may, warnings=_ALLOWED)
    yield from refused({"a load that pulls": _PULLING}, UNIFORM, _OPENS)


def load_steps() -> Runs:
    """Loads in steps: from 1e-12 of the load, and steps a rounding apart."""
    ways = chosen(UNIFORM, "GPTS, penalty", "GPTS, saddle", "mortar, penalty")
    nearly_lost = [1e-12, 1e-8, 1e-4, 1.0]
    for words, steps in (
        ("10 steps", 10),
        ("from 1e-12 of the load", nearly_lost),
        ("two steps a rounding apart", [1.0 - 2**-52, 1.0]),
    ):
        for m, c in ((1.0, 1.0), (2.0, 10.0), (5.0, 1e8)):
            # Under a tiny load the contact stiffness is lost in the rounding of that of the body.
            expected = "honest" if steps == nearly_lost and m > 3.0 else "accurate"
            pressed = pressed_layers(1e-3, c_n=c, m_n=m)
            rows = {f"{words}, m_n = {m:g}": changed(pressed, {"analysis.load_steps": steps})}
            known = pressed_layers(p=_slope(m, 1e-3, c))
            yield from runs(rows, ways, instead=known, expected=expected, warnings=_ALLOWED)
    pulled = changed(_PULLING, {"analysis.load_steps": 5})
    yield from refused({"a load that pulls, in steps": pulled}, _PULLED, _OPENS)


_HEIGHT = 1.5  # height of both layers (m)
_LAYERS = ((0.1, 0.25, 0.5), (1.0, 0.3, 1.0))
"""E, nu and height of each (:func:`comparisons.stability.scenes.layers`)."""


def _held(value: float | None = None, **law: Any) -> Scene:
    """Layers whose back is held, or has a prescribed displacement along y."""
    back: Scene = {"surface": "y_max", "components": ["x", "y"]}
    given = {} if value is None else {"value": [0.0, value]}
    return pressed_layers(back=back | given, **law)


def _closed(value: float, c: float, m: float) -> float:
    """Contact stiffness p of layers of moduli lambda + 2 mu compressed by -value in total."""
    soft = sum(h * (1 + nu) * (1 - 2 * nu) / (E * (1 - nu)) for E, nu, h in _LAYERS)

    def too_far(share: float) -> float:
        return share + c * (-value) ** (m - 1) * share**m * soft - 1.0

    closure = -value * float(brentq(too_far, 0.0, 1.0, xtol=1e-16, rtol=1e-15))
    return m * c * closure ** (m - 1)


def prescribed() -> Runs:
    """A prescribed displacement, from 1e-12 to 10 % of the height."""
    for part in (1e-12, 1e-6, 1e-3, 0.1):
        for m, c in ((1.0, 1.0), (2.0, 1.0 / part), (3.3, part**-2.3)):
            value = -part * _HEIGHT
            rows = {f"{part:.0e} of the height, m_n = {m:g}": _held(value, c_n=c, m_n=m)}
            known = _held(p=_closed(value, c, m))
            yield from runs(rows, UNIFORM, instead=known, warnings=_ALLOWED)
    yield from refused({"pulled away": _held(1e-3, c_n=1.0, m_n=2.0)}, _PULLED, _OPENS)


_BUCKLES = 0.04097906385107964
"""Buckling pressure (N/m^2) of bilinear layers in contact of p = 1 N/m^3.

The least eigenvalue P of K + P K_geo, both tensor products of matrices along x and y.
"""


def prestress() -> Runs:
    """A prestress from 1e-9 of the buckling load to twice as much."""
    for part in (1e-9, 0.5, 0.99, 1 - 1e-6, 1 - 1e-10, 1 + 1e-6, 1.01, 2.0):
        data = pressed_layers(part * _BUCKLES, degree=1, c_n=1.0)
        data = changed(data, {"analysis.geometric_stiffness": True})
        expected = "accurate" if abs(part - 1) > 1e-3 else "honest"
        rows = {f"{part:.10g} of the buckling load": data}
        allowed = (*_ALLOWED, "dead-contact-pressure")
        yield from runs(rows, UNIFORM, expected=expected, warnings=allowed)


def unsupported() -> Runs:
    """Static loads on unsupported bodies."""
    block = body(rectangle((1.0, 0.5), (0.3, 0.0)), (3, 2))
    partly = [{"surface": "y_min", "components": ["x"]}]

    def loaded(P: float = 1e3, **supports: Any) -> Scene:
        data = stacked(block, base((4, 2), **supports), "static", P=P, mu=0.0)
        return data | {"loads": [{"surface": "upper.y_max", "pressure": 1.0}]}

    rows = {
        "no supports": loaded(held=""),
        "one component held": loaded(held="", supports=partly),
        "the upper block may slide": loaded(),
        "no supports, P = 1e14": loaded(1e14, held=""),
    }
    return refused(rows, FEW)


def _with(data: Scene, damping: dict[str, Any], *bodies: str) -> Scene:
    """A scene with damping of some bodies, or of all."""
    changes = {f"bodies.{name}.damping": damping for name in bodies or data["bodies"]}
    return changed(data, {**changes, "analysis.min_growth": -3.0})


def damping() -> Runs:
    """Damping ratios 1e-12 to 1."""
    for ratio in (1e-12, 1e-6, 1e-2, 0.3, 1.0):
        # Modes at both ends of this range of frequencies have the ratio.
        fields: dict[str, Any] = {"ratios": [ratio, ratio], "frequencies": [0.05, 0.6]}
        also = ("undecided",) if ratio == 1e-12 else ()
        rows = {
            f"ζ = {ratio:g}, both": _with(layers(p=10.0), fields),
            f"ζ = {ratio:g}, upper alone": _with(layers(p=10.0), fields, "upper"),
        }
        yield from runs(rows, PAIR, also=also)


def damped_maps() -> Runs:
    """Maps of friction and damping by a reduced model."""
    axes = {
        "contacts.interface.mu": (0.0, 0.5, 1.0),
        "bodies.upper.damping.alpha": (0.0, 0.25, 0.5),
        "bodies.lower.damping.beta": (0.0, 0.05, 0.1),
    }
    for alpha, beta, mu in ((1e-9, 1e-12, 0.83), (3e-3, 1e-3, 0.3), (0.4, 0.07, 0.61)):
        row = f"α = {alpha:g} 1/s, β = {beta:g} s, μ = {mu:g}"
        data = _with(layers(p=10.0, mu=mu), {"alpha": alpha}, "upper")
        data = _with(data, {"beta": beta}, "lower")
        yield from runs({row: data}, PAIR, problem=partial(of_map, axes=axes))


_EVERY = 1e3  # frequency (Hz) above all modes of these bodies


def _square() -> Scene:
    """A square held only by contacts with a base and a wall; its free modes come in pairs."""
    wall = body(rectangle((0.5, 1.0), (1.0, 0.0)), (2, 4), held="x_max")
    ground = body(rectangle((1.0, 1.0), (0.0, -1.0)), (4, 4), held="y_min")
    upwards = {"vector": [0.0, 1.0]}
    data = scene(
        {"square": body(rectangle((1.0, 1.0)), (3, 3)), "base": ground, "wall": wall},
        below=contact("square.y_min", "base.y_max", P=10.0),
        beside=contact("square.x_max", "wall.x_min", P=10.0, friction_direction_on_a=upwards),
    )
    return _with(data, {"modal": {"ratio": 0.05, "max_frequency": _EVERY}}, "square")


def modal_damping() -> Runs:
    """Modal damping, ratios 1e-12 to 0.999."""

    def damped(**modal: Any) -> Scene:
        return _with(layers(p=10.0), {"modal": modal})

    rows = {
        f"ζ = {ratio:g}, all modes": damped(ratio=ratio, max_frequency=_EVERY)
        for ratio in (1e-12, 1e-6, 1e-2, 0.3, 0.999)
    }
    rows["ζ = 0.01 up to 0.3 Hz"] = damped(ratio=1e-2, max_frequency=0.3)
    rows["a table"] = damped(ratios=[0.9, 1e-6, 0.5], frequencies=[0.2, 0.4, _EVERY])
    rows["a free square"] = _square()
    return runs(rows, PAIR)


def sliding_speed() -> Runs:
    """Sliding speeds 1e-6 to 1e6, slopes of friction."""

    def at(speed: float | str, **slope: float | str) -> Scene:
        return unequal_boxes(sliding={"pressure": 0.05, "speed": speed, **slope})

    rows = {
        "v = 1e6": at(1e6),
        "v = 1": at(1.0),
        "v = 1e-6": at(1e-6),
        "v varies": at("0.01 + hypot(x, y)"),
        "μ' = -1e-9": at(1.0, mu_slope=-1e-9),
        "μ' = -1": at(1.0, mu_slope=-1.0),
        "μ' = 1": at(1.0, mu_slope=1.0),
        "μ' changes sign": at(1.0, mu_slope="x - 0.8"),
    }
    return runs(rows, PAIR)


def rotation() -> Runs:
    """A rotating ring, held at its inner rim."""
    may = ("centrifugal-stresses", "faster-than-waves")
    for rate in (1e-9, 1e-3, 0.1, 1.0, 5.0):
        for coriolis in (True, False):
            for convective in (False, True):
                words = f"Ω = {rate:g}, {'with' if coriolis else 'no'} Coriolis forces"
                row = words + (", convective stiffness" if convective else "")
                turning = {"rate": rate, "coriolis": coriolis, "convective_stiffness": convective}
                turned = body(ring(0.5, 1.0), (2, 12), held="inner", rotation=turning)
                yield from runs({row: scene({"ring": turned})}, ALONE, also=may)


_STANDS = 0.0447  # rate (rad/s) at which a wave of two diameters stands if sqrt(E / rho) = 1 m/s
_BETWEEN = 0.15  # kappa (1/s^2) between the waves of three and four diameters, likewise


def _dampings(omega: float) -> Iterator[tuple[str, dict[str, Any], float]]:
    """Yield name, damping, and a decay rate (1/s) above those of waves of two and three diameters.

    Their damping ratios are 0.2 to 0.8. Without mass damping rigid motions have double eigenvalues.
    """
    alpha, beta, ratio = 0.05 * omega, 3.0 / omega, 0.5
    yield "α", {"alpha": 2 * alpha}, 2 * alpha
    decay = (alpha + beta * _BETWEEN * omega**2) / 2
    yield "α and β", {"alpha": alpha, "beta": beta}, decay
    modal = {"ratio": ratio, "max_frequency": 1e3 * omega}
    decay = alpha / 2 + ratio * sqrt(_BETWEEN) * omega
    yield "α and mode by mode", {"alpha": alpha, "modal": modal}, decay


def damped_rotation() -> Runs:
    """A free ring that rotates, heavily damped."""
    for material, E, rho, parts in (
        ("soft", 1.0, 1.0, (0.0, 1.0, 1.5)),
        ("steel", 2e11, 7800.0, (1.5,)),
    ):
        omega = sqrt(E / rho)
        for words, fields, decay in _dampings(omega):
            window = {"kind": "cea", "max_frequency": 0.1 * omega, "min_growth": -decay}
            for part in parts:
                # The decay rate is that at rest, to three digits on this mesh. Rigid motions at
                # rest in space do not decay: the sign of their rate is rounding.
                rate = {"rate": part * _STANDS * omega}
                turning = rate | {"coriolis": False, "convective_stiffness": True}
                moving: Scene = {"rotation": turning, "damping": fields}
                turned = body(ring(0.9, 1.0), (1, 24), degree=3, E=E, rho=rho, **moving)
                row = f"{material}, damped by {words}, {part:g} of the rate of a standing wave"
                may = ("centrifugal-stresses", "undecided") if part else ("centrifugal-stresses",)
                rows = {row: scene({"ring": turned}, window)}
                yield from runs(rows, ALONE, carried, tolerance=1e-3, also=may)
