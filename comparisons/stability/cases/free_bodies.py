"""Bodies without supports: rigid motions, which are modes with lambda = 0."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import Scene, body, contact, rectangle, scene
from comparisons.stability.parts.ways import ALONE, WAYS, chosen


def _plane(mu: float) -> Scene:
    """Two free blocks, one on the other."""
    return scene(
        {
            "upper": body(rectangle((1.0, 0.5), (0.3, 0.0)), (3, 2), E=0.5),
            "lower": body(rectangle((2.0, 1.0), (0.0, -1.0)), (4, 2)),
        },
        contact=contact("upper.y_min", "lower.y_max", p=2.0, mu=mu),
    )


def _space(mu: float) -> Scene:
    """The same in space."""

    def box(size: list[float], origin: list[float], E: float) -> Scene:
        return body({"shape": "box", "size": size, "origin": origin}, (2, 2, 1), E=E)

    return scene(
        {
            "upper": box([1.0, 0.8, 0.5], [0.3, 0.1, 0.0], 0.5),
            "lower": box([2.0, 1.0, 1.0], [0.0, 0.0, -1.0], 1.0),
        },
        contact=contact(
            "upper.z_min",
            "lower.z_max",
            p=2.0,
            mu=mu,
            friction_direction_on_a={"vector": [1.0, 0.0, 0.0]},
        ),
    )


@case("Free bodies: rigid motions", subject="friction and spectra")
def free_bodies() -> Iterator[Run]:
    """Every rigid motion is found, and none is called a growing mode."""
    free = scene({"block": body(rectangle((2.0, 1.0)), (4, 3))})
    for way in ALONE:
        data = way.of(free)
        yield Run("one block", way, OfScene(data), dense(data), tolerance=1e-6)
    for mu in (0.0, 0.3, 1.5):
        for name, make in (("plane", _plane), ("space", _space)):
            for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
                data = way.of(make(mu))
                yield Run(
                    f"two blocks, {name}, μ = {mu:g}",
                    way,
                    OfScene(data),
                    dense(data),
                    tolerance=1e-6,
                    lowest=10,
                )
