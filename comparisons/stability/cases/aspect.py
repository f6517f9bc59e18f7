"""Elements far longer than wide."""

from collections.abc import Iterator

from comparisons.stability.parts.case import ACCURATE, WARNED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import body, contact, rectangle, scene
from comparisons.stability.parts.ways import WAYS, chosen


@case("Elements 1e3 times longer than wide, both ways", subject="geometry")
def aspect() -> Iterator[Run]:
    """Flat layers, and columns whose bending has (1e-3)^4 of the stiffness of their elements."""
    for word, width, height in (("flat", 1e3, 1.0), ("upright", 1.0, 1e3)):
        data = scene(
            {
                "upper": body(
                    rectangle((width, height)), (2, 2), E=0.5, supports=[{"surface": "y_max"}]
                ),
                "lower": body(
                    rectangle((width, height), (0.0, -height)),
                    (3, 2),
                    supports=[{"surface": "y_min"}],
                ),
            },
            contact=contact("upper.y_min", "lower.y_max"),
        )
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
            scene_ = way.of(data)
            if word == "flat":
                yield Run("flat elements", way, OfScene(scene_), dense(scene_), ACCURATE)
            else:
                yield Run("columns", way, OfScene(scene_), dense(scene_), WARNED, tolerance=1e-4)
