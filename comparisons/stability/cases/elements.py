"""Degrees, continuity and shapes of elements and splines."""

from typing import Any

from comparisons.stability.parts.case import HONEST, Case, Rows, refused
from comparisons.stability.parts.references import exact
from comparisons.stability.parts.scenes import (
    Scene,
    boxes,
    changed,
    layers,
    on_base,
    patch,
    patches,
    up_to,
)
from comparisons.stability.parts.ways import MORTAR, WAYS, chosen

SUBJECT = "elements and splines"
_IGA = chosen(WAYS, backend="iga")
_QUADRATIC = [0, 0, 0, 1, 1, 1]
_BOTH = ("upper", "lower")
_FOOT = [[0.5, 0.0], [1.0, 0.0]]


def _weighted(strong: float) -> Scene:
    """A rectangle with weights 1, strong, 1 along x."""
    grid = [[[x, y] for y in (0.0, 0.25, 0.5)] for x in (0.5, 0.75, 1.0)]
    weights = [[1.0] * 3, [strong] * 3, [1.0] * 3]
    return patches(grid, weights, degrees=[2, 2], knots=[_QUADRATIC, _QUADRATIC])


def _repeated(times: int) -> Scene:
    """A rectangle with a knot that is repeated, along x."""
    knots = [0.0, 0.0, 0.0, *[0.4] * times, 1.0, 1.0, 1.0]
    greville = [0.5 + 0.5 * sum(knots[i + 1 : i + 3]) / 2 for i in range(3 + times)]
    points = [[[x, y] for y in (0.0, 0.25, 0.5)] for x in greville]
    return patches(points, degrees=[2, 2], knots=[knots, _QUADRATIC])


_PATCHES = {
    "double knot": _repeated(2),
    "skewed": patch(_FOOT, [[1.4, 0.5], [1.6, 0.5]]),
    "almost inverted": patch(_FOOT, [[0.7499, 0.5], [0.75, 0.5]]),
    "left-handed": patch([[1.0, 0.0], [0.5, 0.0]], [[1.0, 0.5], [0.5, 0.5]]),
}
_STRONG = {
    "weights 10": _weighted(10.0),
    "weights 1e2": _weighted(1e2),
    "weights 1e4": _weighted(1e4),
    "weights 1e-4": _weighted(1e-4),
}
"""Weights that squeeze most of the patch into a sliver, which few Gauss points do not see."""
_INVERTED = {
    "crossed": patch(_FOOT, [[1.0, 0.5], [0.5, 0.5]]),
    "folded": patch(_FOOT, [[0.8, 0.5], [0.7, 0.2]]),
    "flat": patch(_FOOT, [[0.5, 0.0], [1.0, 0.0]]),
}


def _of_degree(degree: int, **fields: Any) -> Scene:
    both = {"degree": degree}
    return layers(upper=both, lower=both, **fields)


def _coarse(degree: int) -> Scene:
    return _of_degree(degree, upper_elements=(3, 1), lower_elements=(2, 2))


def _continuous(degree: int, continuity: int) -> Scene:
    """Collocation points crowd at knots of low continuity."""
    meshes = {f"bodies.{name}.mesh.iga.continuity": [continuity] * 2 for name in _BOTH}
    return changed(_coarse(degree), meshes)


def _boxes() -> Scene:
    size = [1.0, 1.0, 0.5]
    sizes = {
        "upper": (size, [0.0, 0.0, 0.0], (2, 1, 1), 1.0, [{"surface": "z_max"}]),
        "lower": (size, [0.0, 0.0, -0.5], (1, 2, 1), 1.0, [{"surface": "z_min"}]),
    }
    return boxes(sizes)


def _divided(cell: str, degree: int) -> Scene:
    changes = {"cell": cell, "degree": degree}
    fields = {f"bodies.{name}.mesh.fe.{key}": v for name in _BOTH for key, v in changes.items()}
    return changed(layers() if cell == "triangle" else _boxes(), fields)


_SOME = chosen(WAYS, "node", "Greville", "GPTS, penalty", "segments, saddle", "mortar")

CASES = {
    "continuity": Case(
        "Continuity 0 to p - 1 of splines",
        Rows({f"degree {p}, C{c}": _continuous(p, c) for p in (2, 4) for c in range(p)}, _IGA),
    ),
    "degrees": Case(
        "Degrees 1 to 8",
        Rows({f"degree {p}": _coarse(p) for p in range(1, 5)}, _SOME),
        Rows({f"degree {p}": _coarse(p) for p in range(5, 9)}, chosen(_SOME, backend="iga")),
        *(
            Rows(
                {
                    f"degree {p}, exact": up_to(0.4, _of_degree(p, mu="0.3*abs(sin(pi*x/2))"))
                    for p in degrees
                },
                ways,
                exact("blocks", max_frequency=0.4, p=1, mu="0.3"),
                tolerance=1e-3,
            )
            for degrees, ways in (
                (range(3, 5), MORTAR),
                (range(5, 9), chosen(MORTAR, backend="iga")),
            )
        ),
    ),
    "inverted": Case(
        "Inverted and folded patches",
        refused(
            {name: on_base(shape) for name, shape in _INVERTED.items()},
            chosen(_IGA, "GPTS, penalty", "mortar"),
        ),
    ),
    "patches": Case(
        "Strong weights, repeated knots, a pole, distorted cells",
        Rows({"weights 2": on_base(_weighted(2.0))}, _IGA),
        Rows(
            {name: on_base(shape) for name, shape in _STRONG.items()},
            _IGA,
            expected=HONEST,
            tolerance=1e-6,
        ),
        Rows({name: on_base(shape) for name, shape in _PATCHES.items()}, _IGA),
        Rows({"pole": on_base(patch(_FOOT, [[0.75, 0.5], [0.75, 0.5]]), held=False)}, _IGA),
    ),
    "simplices": Case(
        "Triangles and tetrahedra of degree 1 to 4",
        Rows(
            {
                f"{cell}, degree {degree}": _divided(cell, degree)
                for degree, cells in (
                    (1, ("triangle", "tetrahedron")),
                    (2, ("triangle", "tetrahedron")),
                    (4, ("triangle",)),
                )
                for cell in cells
            },
            chosen(
                WAYS, "node", "GPTS, penalty", "GPTS, saddle", "segments", "mortar", backend="fe"
            ),
        ),
    ),
}
