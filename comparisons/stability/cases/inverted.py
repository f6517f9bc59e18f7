"""Geometries that turn inside out."""

from collections.abc import Iterator

from comparisons.stability.parts.case import REFUSED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.scenes import body, contact, patch, rectangle, scene
from comparisons.stability.parts.ways import WAYS, chosen

_SHAPES = {
    "crossed": patch([[0.5, 0.0], [1.0, 0.0]], [[1.0, 0.5], [0.5, 0.5]]),
    "folded": patch([[0.5, 0.0], [1.0, 0.0]], [[0.8, 0.5], [0.7, 0.2]]),
    "flat": patch([[0.5, 0.0], [1.0, 0.0]], [[0.5, 0.0], [1.0, 0.0]]),
}


@case("Inverted and folded patches", subject="elements and splines")
def inverted() -> Iterator[Run]:
    """Where the Jacobian changes its sign or vanishes there is no body."""
    for name, geometry in _SHAPES.items():
        data = scene(
            {
                "pad": body(geometry, (3, 2), supports=[{"surface": "head"}]),
                "base": body(
                    rectangle((2.0, 1.0), (0.0, -1.0)), (5, 3), supports=[{"surface": "y_min"}]
                ),
            },
            contact=contact("pad.foot", "base.y_max"),
        )
        for way in chosen(WAYS, "GPTS, penalty", "mortar", backend="iga"):
            own = way.of(data)
            yield Run(name, way, OfScene(own), None, REFUSED)
