"""Layers pressed together by a displacement of their back, from 1e-12 to 10 % of their height."""

from collections.abc import Iterator
from typing import Any

from scipy.optimize import brentq

from comparisons.stability.parts.case import REFUSED, Run, case
from comparisons.stability.parts.pressed_layers import (
    ALLOWED,
    UNIFORM_WAYS,
    pressed_layers,
    uniform,
)
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.ways import Way, chosen

_HEIGHT = 1.5
"""Of both layers."""
_LAYERS = ((0.1, 0.25, 0.5), (1.0, 0.3, 1.0))
"""E, nu and height of each (:func:`comparisons.stability.parts.scenes.layers`)."""


def _held(way: Way, value: float, c: float, m: float) -> dict[str, Any]:
    """Layers whose back is held, at a displacement along y."""
    data = pressed_layers(way, 1.0, c_n=c, m_n=m) | {"loads": []}
    walls = data["bodies"]["upper"]["supports"][1:]
    back = {"surface": "y_max", "components": ["x", "y"], "value": [0.0, value]}
    data["bodies"]["upper"]["supports"] = [back, *walls]
    return data


def _slope(value: float, c: float, m: float) -> float:
    """Contact stiffness p where layers of the moduli lambda + 2 mu are closed by -value in all."""
    soft = sum(h * (1 + nu) * (1 - 2 * nu) / (E * (1 - nu)) for E, nu, h in _LAYERS)

    def too_far(share: float) -> float:
        return share + c * (-value) ** (m - 1) * share**m * soft - 1.0

    closure = -value * float(brentq(too_far, 0.0, 1.0, xtol=1e-16, rtol=1e-15))
    return m * c * closure ** (m - 1)


@case("A prescribed displacement, from 1e-12 to 10 % of the height", subject="load")
def prescribed() -> Iterator[Run]:
    """Between rollers the closure follows from the height of the layers, and p from it."""
    for part in (1e-12, 1e-6, 1e-3, 0.1):
        for m, c in ((1.0, 1.0), (2.0, 1.0 / part), (3.3, part**-2.3)):
            value = -part * _HEIGHT
            for way in UNIFORM_WAYS:
                data = _held(way, value, c, m)
                truth = uniform(data, _slope(value, c, m))
                truth["bodies"]["upper"]["supports"][0].pop("value")
                row = f"{part:.0e} of the height, m_n = {m:g}"
                yield Run(row, way, OfScene(data), dense(truth), warnings=ALLOWED)
    for way in chosen(UNIFORM_WAYS, "GPTS, penalty", "mortar, penalty"):
        data = _held(way, 1e-3, 1.0, 2.0)
        names = "the load opens the contact"
        yield Run("pulled away", way, OfScene(data), None, REFUSED, names=names)
