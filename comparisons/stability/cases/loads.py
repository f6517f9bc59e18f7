"""Loads: steady sliding under normal compliance, steps, prescribed displacements, prestress."""

from functools import partial
from typing import Any

from scipy.optimize import brentq

from comparisons.stability.parts.case import ACCURATE, HONEST, Case, Rows, refused
from comparisons.stability.parts.prestressed import (
    Layer,
    buckling_pressure,
    prestressed_eigenvalues,
)
from comparisons.stability.parts.references import Reference, dense
from comparisons.stability.parts.scenes import (
    HELD_BELOW,
    WALLS,
    Scene,
    base,
    body,
    changed,
    contact,
    pressed_layers,
    rectangle,
    scene,
    uniform,
)
from comparisons.stability.parts.ways import FEW, UNIFORM, chosen

SUBJECT = "load"
_STIFF = 1e5
"""p above which a penalty loses digits; bodies have E = 1."""
_ALLOWED = ("over-constrained", "under-sampled", "short-modes", "point-rule")
"""Warnings that such runs may give."""
_OPENS = "the load opens the contact"
_SOME = chosen(UNIFORM, "GPTS, penalty", "GPTS, saddle", "mortar, penalty")
_PULLED = chosen(UNIFORM, "GPTS, penalty", "mortar, penalty")


def _known(p: float, data: Scene) -> Reference:
    """Dense eigenvalues of the same layers where p is known."""
    return dense(uniform(data, p))


def _sliding(m: float, pressure: float, c: float) -> Rows:
    """Between rollers a pressure makes a uniform closure, and p follows by a formula."""
    p = m * c * ((pressure / c) ** (1 / m)) ** (m - 1)
    return Rows(
        {
            f"m_n = {m:g}, pressure {pressure:.0e}, p = {p:.0e}": pressed_layers(
                pressure, c_n=c, m_n=m
            )
        },
        UNIFORM,
        partial(_known, p),
        warnings=_ALLOWED,
        expected=ACCURATE if p < _STIFF else HONEST,
    )


_NEARLY_LOST = [1e-12, 1e-8, 1e-4, 1.0]


def _steps(words: str, steps: Any, m: float, c: float) -> Rows:
    """On whatever way the load is put on, p is that of the whole of it."""
    pressure = 1e-3
    p = m * c * (pressure / c) ** ((m - 1) / m)
    data = changed(pressed_layers(pressure, c_n=c, m_n=m), {"analysis.load_steps": steps})
    # Pressed by next to nothing a body floats but for the digits of its stiffness.
    expected = HONEST if steps == _NEARLY_LOST and m > 3.0 else ACCURATE
    row = {f"{words}, m_n = {m:g}": data}
    return Rows(row, _SOME, partial(_known, p), expected=expected, warnings=_ALLOWED)


_HEIGHT = 1.5
"""Of both layers."""
_LAYERS = ((0.1, 0.25, 0.5), (1.0, 0.3, 1.0))
"""E, nu and height of each (:func:`comparisons.stability.parts.scenes.layers`)."""


def _held(value: float, c: float, m: float) -> Scene:
    """Layers whose back is held, at a displacement along y."""
    data = pressed_layers(1.0, c_n=c, m_n=m) | {"loads": []}
    back = {"surface": "y_max", "components": ["x", "y"], "value": [0.0, value]}
    data["bodies"]["upper"]["supports"] = [back, *WALLS]
    return data


def _slope(value: float, c: float, m: float) -> float:
    """Contact stiffness p where layers of the moduli lambda + 2 mu are closed by -value in all."""
    soft = sum(h * (1 + nu) * (1 - 2 * nu) / (E * (1 - nu)) for E, nu, h in _LAYERS)

    def too_far(share: float) -> float:
        return share + c * (-value) ** (m - 1) * share**m * soft - 1.0

    closure = -value * float(brentq(too_far, 0.0, 1.0, xtol=1e-16, rtol=1e-15))
    return m * c * closure ** (m - 1)


def _prescribed(part: float, m: float, c: float) -> Rows:
    value = -part * _HEIGHT
    p = _slope(value, c, m)

    def true(data: Scene) -> Reference:
        known = uniform(data, p)
        known["bodies"]["upper"]["supports"][0].pop("value")
        return dense(known)

    row = {f"{part:.0e} of the height, m_n = {m:g}": _held(value, c, m)}
    return Rows(row, UNIFORM, true, warnings=_ALLOWED)


_UPPER, _LOWER = Layer(0.1, 0.25, 0.35, 0.5, (5, 2)), Layer(1.0, 0.3, 1.0, 1.0, (5, 3))
"""Those of :func:`comparisons.stability.parts.scenes.layers`."""


def _prestress(part: float) -> Rows:
    """A prestress, as a part of the buckling pressure; the reference is a formula."""
    pressure = part * buckling_pressure(_UPPER, _LOWER, 1.0)
    data = pressed_layers(pressure, degree=1, c_n=1.0)
    true = partial(prestressed_eigenvalues, _UPPER, _LOWER, 1.0, pressure)
    return Rows(
        {
            f"{part:.10g} of the buckling load": changed(
                data, {"analysis.geometric_stiffness": True}
            )
        },
        UNIFORM,
        Reference("formula", true),
        warnings=_ALLOWED,
        expected=ACCURATE if abs(part - 1) > 1e-3 else HONEST,
    )


def _unsupported(*supports: Scene, P: float = 1e3) -> Scene:
    """A block that is pressed on another."""
    upper = body(rectangle((1.0, 0.5), (0.3, 0.0)), (3, 2))
    data = scene(
        {"upper": upper, "lower": base((4, 2), supports=supports)},
        contact=contact("upper.y_min", "lower.y_max", P=P, mu=0.0),
    )
    loads = [{"surface": "upper.y_max", "pressure": 1.0}]
    return changed(data, {"analysis": {"kind": "static"}, "loads": loads})


CASES = {
    "load_steps": Case(
        "Loads in steps: from 1e-12 of the load, and steps a rounding apart",
        *(
            _steps(words, steps, m, c)
            for words, steps in (
                ("10 steps", 10),
                ("from 1e-12 of the load", _NEARLY_LOST),
                ("two steps a rounding apart", [1.0 - 2**-52, 1.0]),
            )
            for m, c in ((1.0, 1.0), (2.0, 10.0), (5.0, 1e8))
        ),
        refused(
            {
                "a load that pulls, in steps": changed(
                    pressed_layers(-1e-3, c_n=1.0, m_n=2.0), {"analysis.load_steps": 5}
                )
            },
            _PULLED,
            _OPENS,
        ),
    ),
    "prescribed": Case(
        "A prescribed displacement, from 1e-12 to 10 % of the height",
        *(
            _prescribed(part, m, c)
            for part in (1e-12, 1e-6, 1e-3, 0.1)
            for m, c in ((1.0, 1.0), (2.0, 1.0 / part), (3.3, part**-2.3))
        ),
        refused({"pulled away": _held(1e-3, 1.0, 2.0)}, _PULLED, _OPENS),
    ),
    "prestress": Case(
        "A prestress from 1e-9 of the buckling load to twice as much",
        *(_prestress(part) for part in (1e-9, 0.5, 0.99, 1 - 1e-6, 1 - 1e-10, 1 + 1e-6, 1.01, 2.0)),
    ),
    "steady_sliding": Case(
        "Normal compliance: m_n from 1 to 5, loads from 1e-12, c_n to nearly rigid",
        *(
            _sliding(m, pressure, c)
            for m, pressure, c in (
                (1.0, 1e-3, 1.0),
                (2.0, 1e-3, 10.0),
                (3.3, 1e-3, 1e4),
                (5.0, 1e-3, 1e8),
                (2.0, 1e-12, 1e4),
                (5.0, 1e-10, 1e30),
                (2.0, 1e-3, 1e9),
            )
        ),
        refused({"a load that pulls": pressed_layers(-1e-3, c_n=1.0, m_n=2.0)}, UNIFORM, _OPENS),
    ),
    "unsupported": Case(
        "Static loads on bodies that nothing holds",
        refused(
            {
                "no supports": _unsupported(),
                "one component held": _unsupported({"surface": "y_min", "components": ["x"]}),
                "the upper block may slide": _unsupported(*HELD_BELOW),
                "no supports, P = 1e14": _unsupported(P=1e14),
            },
            FEW,
        ),
        subject="what is refused",
    ),
}
