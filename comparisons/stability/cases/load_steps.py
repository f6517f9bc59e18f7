"""Loads put on in steps, from a contact that is nearly lost to the whole of them."""

from collections.abc import Iterator
from typing import Any

from comparisons.stability.parts.case import ACCURATE, HONEST, REFUSED, Run, case
from comparisons.stability.parts.pressed_layers import (
    ALLOWED,
    UNIFORM_WAYS,
    pressed_layers,
    uniform,
)
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.ways import chosen

_PRESSURE = 1e-3
_NEARLY_LOST = [1e-12, 1e-8, 1e-4, 1.0]
_FLOATS = 3.0
"""Exponent from which a law has next to no stiffness at the first of these."""
_STEPS: dict[str, Any] = {
    "10 steps": 10,
    "from 1e-12 of the load": _NEARLY_LOST,
    "two steps a rounding apart": [1.0 - 2**-52, 1.0],
}


@case("Loads in steps: from 1e-12 of the load, and steps a rounding apart", subject="load")
def load_steps() -> Iterator[Run]:
    """On whatever way the load is put on, p is that of the whole of it."""
    for words, steps in _STEPS.items():
        for m, c in ((1.0, 1.0), (2.0, 10.0), (5.0, 1e8)):
            p = m * c * (_PRESSURE / c) ** ((m - 1) / m)
            for way in chosen(UNIFORM_WAYS, "GPTS, penalty", "GPTS, saddle", "mortar, penalty"):
                data = pressed_layers(way, _PRESSURE, c_n=c, m_n=m)
                truth = dense(uniform(data, p))
                data["analysis"] |= {"load_steps": steps}
                row = f"{words}, m_n = {m:g}"
                # Pressed by next to nothing a body floats but for the digits of its stiffness.
                expected = HONEST if steps == _NEARLY_LOST and m > _FLOATS else ACCURATE
                yield Run(row, way, OfScene(data), truth, expected, warnings=ALLOWED)
    for way in chosen(UNIFORM_WAYS, "GPTS, penalty", "mortar, penalty"):
        data = pressed_layers(way, -_PRESSURE, c_n=1.0, m_n=2.0)
        data["analysis"] |= {"load_steps": 5}
        names = "the load opens the contact"
        yield Run("a load that pulls, in steps", way, OfScene(data), None, REFUSED, names=names)
