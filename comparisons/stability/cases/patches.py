"""NURBS patches with strong weights, repeated knots, a pole, distorted cells."""

from collections.abc import Iterator

from comparisons.stability.parts.case import ACCURATE, HONEST, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import (
    Scene,
    body,
    contact,
    patch,
    patches,
    rectangle,
    scene,
)
from comparisons.stability.parts.ways import WAYS, chosen

_QUADRATIC = [0, 0, 0, 1, 1, 1]
_HELD = {"surface": "head"}
_GRID = [[[x, y] for y in (0.0, 0.25, 0.5)] for x in (0.5, 0.75, 1.0)]


def _weighted(strong: float) -> Scene:
    """A rectangle with weights 1, strong, 1 along x."""
    weights = [[1.0] * 3, [strong] * 3, [1.0] * 3]
    return patches(_GRID, weights, degrees=[2, 2], knots=[_QUADRATIC, _QUADRATIC])


def _repeated(times: int) -> Scene:
    """A rectangle with a knot that is repeated, along x."""
    knots = [0.0, 0.0, 0.0, *[0.4] * times, 1.0, 1.0, 1.0]
    greville = [0.5 + 0.5 * sum(knots[i + 1 : i + 3]) / 2 for i in range(3 + times)]
    points = [[[x, y] for y in (0.0, 0.25, 0.5)] for x in greville]
    return patches(points, degrees=[2, 2], knots=[knots, _QUADRATIC])


_SHAPES = {
    "weights 2": _weighted(2.0),
    "weights 10": _weighted(10.0),
    "weights 1e2": _weighted(1e2),
    "weights 1e4": _weighted(1e4),
    "weights 1e-4": _weighted(1e-4),
    "double knot": _repeated(2),
    "skewed": patch([[0.5, 0.0], [1.0, 0.0]], [[1.4, 0.5], [1.6, 0.5]]),
    "almost inverted": patch([[0.5, 0.0], [1.0, 0.0]], [[0.7499, 0.5], [0.75, 0.5]]),
    "left-handed": patch([[1.0, 0.0], [0.5, 0.0]], [[1.0, 0.5], [0.5, 0.5]]),
    "pole": patch([[0.5, 0.0], [1.0, 0.0]], [[0.75, 0.5], [0.75, 0.5]]),
}

_STRONG = ("weights 10", "weights 1e2", "weights 1e4", "weights 1e-4")
"""Weights that squeeze most of the patch into a sliver, which few Gauss points do not see."""


@case("Strong weights, repeated knots, a pole, distorted cells", subject="elements and splines")
def patches_() -> Iterator[Run]:
    """A patch of each kind, pressed on a base."""
    for name, geometry in _SHAPES.items():
        data = scene(
            {
                "pad": body(geometry, (3, 2), supports=[] if name == "pole" else [_HELD]),
                "base": body(
                    rectangle((2.0, 1.0), (0.0, -1.0)), (5, 3), supports=[{"surface": "y_min"}]
                ),
            },
            contact=contact("pad.foot", "base.y_max"),
        )
        for way in chosen(WAYS, backend="iga"):
            own = way.of(data)
            strong = name in _STRONG
            expected, tolerance = (HONEST, 1e-6) if strong else (ACCURATE, 1e-8)
            yield Run(name, way, OfScene(own), dense(own), expected, tolerance)
