"""Static loads on bodies that nothing holds."""

from collections.abc import Iterator

from comparisons.stability.parts.case import REFUSED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.scenes import Scene, body, changed, contact, rectangle, scene
from comparisons.stability.parts.ways import WAYS, chosen


def _pressed(*supports: Scene, P: float = 1e3) -> Scene:
    """A block that is pressed on another."""
    data = scene(
        {
            "upper": body(rectangle((1.0, 0.5), (0.3, 0.0)), (3, 2)),
            "lower": body(rectangle((2.0, 1.0), (0.0, -1.0)), (4, 2), supports=supports),
        },
        contact=contact("upper.y_min", "lower.y_max", P=P, mu=0.0),
    )
    loads = [{"surface": "upper.y_max", "pressure": 1.0}]
    return changed(data, {"analysis": {"kind": "static"}, "loads": loads})


_SCENES = {
    "no supports": _pressed(),
    "one component held": _pressed({"surface": "y_min", "components": ["x"]}),
    "the upper block may slide": _pressed({"surface": "y_min"}),
    "no supports, P = 1e14": _pressed(P=1e14),
}


@case("Static loads on bodies that nothing holds", subject="what is refused")
def unsupported() -> Iterator[Run]:
    """A singular system has no displacement."""
    for name, data in _SCENES.items():
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
            yield Run(name, way, OfScene(way.of(data)), None, REFUSED)
