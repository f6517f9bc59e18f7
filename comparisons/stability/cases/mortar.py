"""Mortar beside exact eigenvalues, from soft contact to a tie."""

from collections.abc import Iterator
from math import inf
from typing import Any

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import exact
from comparisons.stability.parts.scenes import Scene, body, changed, contact, layers, scene
from comparisons.stability.parts.ways import WAYS, chosen

_STIFFNESSES = (1e-2, 1.0, 1e3, 1e6, 1e9, 1e12, inf)
_FREQUENCY = {"blocks": 0.42, "drum": 0.33}
_DEGREE = {"degree": 3}


def _blocks(p: float) -> Scene:
    return layers(
        upper=_DEGREE,
        lower=_DEGREE,
        upper_elements=(8, 3),
        lower_elements=(7, 4),
        p=p,
        mu="0.3*abs(sin(pi*x/2))",
    )


def _drum(p: float) -> Scene:
    def ring(inner: float, outer: float, elements: tuple[int, int], **fields: Any) -> Scene:
        geometry = {"shape": "ring", "inner_radius": inner, "outer_radius": outer}
        return body(geometry, elements, degree=3, **fields)

    about = {"circumferential_about": [0.0, 0.0, 1.0]}
    return scene(
        {
            "outer": ring(
                *(1.0, 1.5, (2, 20)), E=0.1, nu=0.25, rho=0.35, supports=[{"surface": "outer"}]
            ),
            "inner": ring(0.5, 1.0, (2, 16), supports=[{"surface": "inner"}]),
        },
        interface=contact("outer.inner", "inner.outer", p=p, friction_direction_on_a=about),
    )


@case("Mortar beside exact eigenvalues, p from 1e-2 N/m³ to infinity", subject="contact stiffness")
def mortar() -> Iterator[Run]:
    """It does not lock, and its saddle form loses no digits: the error is that of the mesh."""
    for problem, make in (("blocks", _blocks), ("drum", _drum)):
        frequency = _FREQUENCY[problem]
        for p in _STIFFNESSES:
            true = exact(problem, max_frequency=frequency, p="inf" if p == inf else p, mu="0.3")
            for way in chosen(WAYS, "mortar, saddle"):
                data = changed(way.of(make(p)), {"analysis.max_frequency": frequency})
                row = f"{problem}, p = {p:.0e} N/m³"
                yield Run(row, way, OfScene(data), true, tolerance=1e-3)
