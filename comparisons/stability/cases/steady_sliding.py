"""Layers pressed together by normal compliance, from next to no load to a nearly rigid contact."""

from collections.abc import Iterator
from typing import Any

from comparisons.stability.parts.case import ACCURATE, HONEST, REFUSED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import changed, layers
from comparisons.stability.parts.ways import OPEN, PENALTY, SADDLE, Way

_WAYS = tuple(
    way
    for way in (*PENALTY, *SADDLE, *OPEN)
    if way.name.startswith(("GPTS,", "segments", "mortar")) and way.name != "mortar, saddle"
)
"""Those that pass a uniform pressure on meshes that match, and that a law can meet."""
_BACK = {"surface": "y_max", "components": ["x"]}
_WALLS = [{"surface": f"x_{end}", "components": ["x"]} for end in ("min", "max")]


def _pressed(way: Way, pressure: float, **law: Any) -> dict[str, Any]:
    """Layers of which a pressure on its back presses the upper one on the lower one."""
    data = way.of(layers(p=1.0, mu=0.0, lower_elements=(5, 3)))
    del data["contacts"]["interface"]["p"]
    data["contacts"]["interface"] |= law
    data["bodies"]["upper"]["supports"] = [_BACK, *_WALLS]
    return data | {"loads": [{"surface": "upper.y_max", "pressure": pressure}]}


def _uniform(data: dict[str, Any], p: float) -> dict[str, Any]:
    """The same where p is known: between rollers pressure and closure are uniform."""
    interface = dict(data["contacts"]["interface"])
    for name in ("c_n", "m_n"):
        interface.pop(name)
    return changed(data, {"contacts.interface": interface | {"p": p}}) | {"loads": []}


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
        for way in _WAYS:
            data = _pressed(way, pressure, c_n=c, m_n=m)
            expected = ACCURATE if p < _STIFF else HONEST
            row = f"m_n = {m:g}, pressure {pressure:.0e}, p = {p:.0e}"
            warnings = ("over-constrained", "under-sampled", "short-modes", "point-rule")
            yield Run(
                row, way, OfScene(data), dense(_uniform(data, p)), expected, warnings=warnings
            )
    for way in _WAYS:
        data = _pressed(way, -1e-3, c_n=1.0, m_n=2.0)
        names = "the load opens the contact"
        yield Run("a load that pulls", way, OfScene(data), None, REFUSED, names=names)


_STIFF = 1e5
"""p above which a penalty loses digits; bodies have E = 1."""
