"""Layers pressed together by normal compliance, from next to no load to a nearly rigid contact."""

from collections.abc import Iterator

from comparisons.stability.parts.case import ACCURATE, HONEST, REFUSED, Run, case
from comparisons.stability.parts.pressed_layers import (
    ALLOWED,
    STIFF,
    UNIFORM_WAYS,
    pressed_layers,
    uniform,
)
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense


@case("Normal compliance: m_n from 1 to 5, loads from 1e-12, c_n to nearly rigid", subject="load")
def steady_sliding() -> Iterator[Run]:
    """Between rollers a pressure makes a uniform closure, and p follows by a formula."""
    for m, pressure, c in (
        (1.0, 1e-3, 1.0),
        (2.0, 1e-3, 10.0),
        (3.3, 1e-3, 1e4),
        (5.0, 1e-3, 1e8),
        (2.0, 1e-12, 1e4),
        (5.0, 1e-10, 1e30),
        (2.0, 1e-3, 1e9),
    ):
        closure = (pressure / c) ** (1 / m)
        p = m * c * closure ** (m - 1)
        for way in UNIFORM_WAYS:
            data = pressed_layers(way, pressure, c_n=c, m_n=m)
            expected = ACCURATE if p < STIFF else HONEST
            row = f"m_n = {m:g}, pressure {pressure:.0e}, p = {p:.0e}"
            truth = dense(uniform(data, p))
            yield Run(row, way, OfScene(data), truth, expected, warnings=ALLOWED)
    for way in UNIFORM_WAYS:
        data = pressed_layers(way, -1e-3, c_n=1.0, m_n=2.0)
        names = "the load opens the contact"
        yield Run("a load that pulls", way, OfScene(data), None, REFUSED, names=names)
