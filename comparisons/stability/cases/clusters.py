"""Twenty equal systems: every eigenvalue twenty times."""

from collections.abc import Iterator

from comparisons.stability.parts.case import MESH, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import copies
from comparisons.stability.parts.scenes import Scene, body, contact, rectangle, scene, sprag
from comparisons.stability.parts.ways import ALONE, WAYS, chosen

_COPIES = 20
_IN_ONE_PLACE = (*MESH, "bodies-overlap")
"""Copies lie where the others do."""


def _alone(number: int) -> Scene:
    """Equal squares, each on its own ground."""
    square = body(rectangle((1.0, 1.0)), (2, 2), supports=[{"surface": "y_min"}])
    return scene({f"b{i}": square for i in range(number)})


def _pairs(number: int, mu: float) -> Scene:
    """Equal pairs of a square that rubs on another."""
    upper = body(rectangle((1.0, 1.0)), (1, 1), supports=[{"surface": "y_max"}])
    lower = body(rectangle((1.0, 1.0), (0.0, -1.0)), (2, 1), E=0.7, supports=[{"surface": "y_min"}])
    bodies = {f"u{i}": upper for i in range(number)} | {f"l{i}": lower for i in range(number)}
    contacts = {f"c{i}": contact(f"u{i}.y_min", f"l{i}.y_max", mu=mu) for i in range(number)}
    return scene(bodies, **contacts)


def _sprags(number: int) -> Scene:
    """Equal sprags, all of which diverge."""
    one = sprag(mu=1.0)
    bodies = {f"{name}{i}": each for i in range(number) for name, each in one["bodies"].items()}
    contacts = {
        f"c{i}": one["contacts"]["contact"] | {"a": f"block{i}.y_min", "b": f"base{i}.y_max"}
        for i in range(number)
    }
    return scene(bodies, **contacts)


@case("Clusters of 20 equal eigenvalues, with and without friction", subject="friction and spectra")
def clusters() -> Iterator[Run]:
    """No copy is missed, and none made up."""
    for way in ALONE:
        data = way.of(_alone(_COPIES))
        true = copies(_COPIES, way.of(_alone(1)))
        yield Run(
            "20 squares", way, OfScene(data), true, lowest=3 * _COPIES, warnings=_IN_ONE_PLACE
        )
    for mu in (0.0, 0.3):
        for way in chosen(WAYS, "GPTS, penalty", "mortar"):
            data = way.of(_pairs(_COPIES, mu))
            row = f"20 pairs, μ = {mu:g}"
            true = copies(_COPIES, way.of(_pairs(1, mu)))
            yield Run(row, way, OfScene(data), true, lowest=2 * _COPIES, warnings=_IN_ONE_PLACE)
    for way in chosen(WAYS, "GPTS, penalty", "mortar"):
        data = way.of(_sprags(5))
        true = copies(5, way.of(_sprags(1)))
        yield Run("5 sprags", way, OfScene(data), true, lowest=15, warnings=_IN_ONE_PLACE)
