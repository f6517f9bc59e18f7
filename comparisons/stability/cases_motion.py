"""Loads, damping and rotation, from next to nothing to critical."""

from functools import partial
from typing import Any

from scipy.optimize import brentq

from comparisons.stability.case import Reference, Runs, dense, refused, runs
from comparisons.stability.scenes import (
    WALLS,
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
    unequal_boxes,
    uniform,
)
from comparisons.stability.ways import ALONE, FEW, PAIR, UNIFORM, chosen

_ALLOWED = ("over-constrained", "under-sampled", "short-modes", "point-rule")
"""Warnings that runs under load may give."""
_OPENS = "the load opens the contact"
_PULLED = chosen(UNIFORM, "GPTS, penalty", "mortar, penalty")


def _slope(m: float, pressure: float, c: float) -> float:
    """Contact stiffness p where a pressure closes layers between rollers everywhere alike."""
    return m * c * (pressure / c) ** ((m - 1) / m)


def _known(p: float, data: Scene) -> Reference:
    """Dense eigenvalues of the same layers where p is known and the back is held where it is."""
    return dense(uniform(data, p))


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
        row = f"m_n = {m:g}, pressure {pressure:.0e}, p = {p:.0e}"
        true, expected = partial(_known, p), "accurate" if p < 1e5 else "honest"  # beside E = 1
        yield from runs(row, data, UNIFORM, true, expected=expected, warnings=_ALLOWED)
    pulls = pressed_layers(-1e-3, c_n=1.0, m_n=2.0)
    yield from refused("a load that pulls", pulls, UNIFORM, _OPENS)


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
            # Pressed by next to nothing a body floats but for the digits of its stiffness.
            expected = "honest" if steps == nearly_lost and m > 3.0 else "accurate"
            pressed = pressed_layers(1e-3, c_n=c, m_n=m)
            data = changed(pressed, {"analysis.load_steps": steps})
            true, row = partial(_known, _slope(m, 1e-3, c)), f"{words}, m_n = {m:g}"
            yield from runs(row, data, ways, true, expected=expected, warnings=_ALLOWED)
    pulled = changed(pressed_layers(-1e-3, c_n=1.0, m_n=2.0), {"analysis.load_steps": 5})
    yield from refused("a load that pulls, in steps", pulled, _PULLED, _OPENS)


_HEIGHT = 1.5  # height of both layers (m)
_LAYERS = ((0.1, 0.25, 0.5), (1.0, 0.3, 1.0))
"""E, nu and height of each (:func:`comparisons.stability.scenes.layers`)."""


def _held(value: float, c: float, m: float) -> Scene:
    """Layers whose back is held, at a displacement along y."""
    data = pressed_layers(1.0, c_n=c, m_n=m) | {"loads": []}
    back = {"surface": "y_max", "components": ["x", "y"], "value": [0.0, value]}
    data["bodies"]["upper"]["supports"] = [back, *WALLS]
    return data


def _closed(value: float, c: float, m: float) -> float:
    """Contact stiffness p where layers of the moduli lambda + 2 mu are closed by -value in all."""
    soft = sum(h * (1 + nu) * (1 - 2 * nu) / (E * (1 - nu)) for E, nu, h in _LAYERS)

    def too_far(share: float) -> float:
        return share + c * (-value) ** (m - 1) * share**m * soft - 1.0

    closure = -value * float(brentq(too_far, 0.0, 1.0, xtol=1e-16, rtol=1e-15))
    return m * c * closure ** (m - 1)


def prescribed() -> Runs:
    """A prescribed displacement, from 1e-12 to 10 % of the height."""
    for part in (1e-12, 1e-6, 1e-3, 0.1):
        for m, c in ((1.0, 1.0), (2.0, 1.0 / part), (3.3, part**-2.3)):
            row, value = f"{part:.0e} of the height, m_n = {m:g}", -part * _HEIGHT
            true = partial(_known, _closed(value, c, m))
            yield from runs(row, _held(value, c, m), UNIFORM, true, warnings=_ALLOWED)
    yield from refused("pulled away", _held(1e-3, 1.0, 2.0), _PULLED, _OPENS)


_BUCKLES = 0.04097906385107964
"""Pressure (N/m^2) at which bilinear layers have no stiffness left, in contact of p = 1 N/m^3.

The least eigenvalue of K + P K_geo, both of products of matrices along x and y.
"""


def prestress() -> Runs:
    """A prestress from 1e-9 of the buckling load to twice as much."""
    for part in (1e-9, 0.5, 0.99, 1 - 1e-6, 1 - 1e-10, 1 + 1e-6, 1.01, 2.0):
        data = pressed_layers(part * _BUCKLES, degree=1, c_n=1.0)
        data = changed(data, {"analysis.geometric_stiffness": True})
        expected = "accurate" if abs(part - 1) > 1e-3 else "honest"
        row = f"{part:.10g} of the buckling load"
        yield from runs(row, data, UNIFORM, expected=expected, warnings=_ALLOWED)


def unsupported() -> Runs:
    """Static loads on bodies that nothing holds."""
    block = body(rectangle((1.0, 0.5), (0.3, 0.0)), (3, 2))
    partly = [{"surface": "y_min", "components": ["x"]}]
    for row, lower, P in (
        ("no supports", base((4, 2), held=""), 1e3),
        ("one component held", base((4, 2), held="", supports=partly), 1e3),
        ("the upper block may slide", base((4, 2)), 1e3),
        ("no supports, P = 1e14", base((4, 2), held=""), 1e14),
    ):
        bodies = {"upper": block, "lower": lower}
        data = scene(bodies, contact=contact("upper.y_min", "lower.y_max", P=P, mu=0.0))
        loads = [{"surface": "upper.y_max", "pressure": 1.0}]
        data = changed(data, {"analysis": {"kind": "static"}, "loads": loads})
        yield from refused(row, data, FEW)


def _with(data: Scene, damping: dict[str, Any], *bodies: str) -> Scene:
    """A scene with damping of some bodies, or of all."""
    changes = {f"bodies.{name}.damping": damping for name in bodies or data["bodies"]}
    return changed(data, {**changes, "analysis.min_growth": -3.0})


def damping() -> Runs:
    """Damping ratios 1e-12 to 1."""
    for ratio in (1e-12, 1e-6, 1e-2, 0.3, 1.0):
        # Both ends of the modes looked at have the ratio.
        fields: dict[str, Any] = {"ratios": [ratio, ratio], "frequencies": [0.05, 0.6]}
        also = ("undecided",) if ratio == 1e-12 else ()
        both, upper = _with(layers(p=10.0), fields), _with(layers(p=10.0), fields, "upper")
        yield from runs(f"ζ = {ratio:g}, both", both, PAIR, also=also)
        yield from runs(f"ζ = {ratio:g}, upper alone", upper, PAIR, also=also)


_EVERY = 1e3  # frequency (Hz) above all modes of these bodies


def _square() -> Scene:
    """A square that contacts alone hold, at a base and at a wall: alone its modes come in pairs."""
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
    rows: dict[str, dict[str, Any]] = {
        f"ζ = {ratio:g}, all modes": {"ratio": ratio, "max_frequency": _EVERY}
        for ratio in (1e-12, 1e-6, 1e-2, 0.3, 0.999)
    }
    rows["ζ = 0.01 up to 0.3 Hz"] = {"ratio": 1e-2, "max_frequency": 0.3}
    rows["a list to next to critical"] = {"ratios": [0.999, 1e-12, 0.0, 0.5, 0.999999]}
    rows["a table"] = {"ratios": [0.9, 1e-6, 0.5], "frequencies": [0.2, 0.4, _EVERY]}
    for row, modal in rows.items():
        is_list = "frequencies" not in modal and "ratios" in modal
        data = _with(layers(p=10.0), {"modal": modal}, *(["upper"] if is_list else []))
        yield from runs(row, data, PAIR, also=("undecided",) if is_list else ())
    yield from runs("a free square", _square(), PAIR)


def sliding_speed() -> Runs:
    """Sliding speeds 1e-6 to 1e6, slopes of friction."""
    sliding: dict[str, Scene] = {
        "v = 1e6": {"speed": 1e6},
        "v = 1": {"speed": 1.0},
        "v = 1e-6": {"speed": 1e-6},
        "v varies": {"speed": "0.01 + hypot(x, y)"},
        "μ' = -1e-9": {"speed": 1.0, "mu_slope": -1e-9},
        "μ' = -1": {"speed": 1.0, "mu_slope": -1.0},
        "μ' = 1": {"speed": 1.0, "mu_slope": 1.0},
        "μ' changes sign": {"speed": 1.0, "mu_slope": "x - 0.8"},
    }
    for row, fields in sliding.items():
        yield from runs(row, unequal_boxes(sliding={"pressure": 0.05} | fields), PAIR)


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
                yield from runs(row, scene({"ring": turned}), ALONE, also=may)
