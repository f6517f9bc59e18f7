"""Directions of friction that are none."""

from collections.abc import Iterator

from comparisons.stability.parts.case import REFUSED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.scenes import Scene, body, contact, layers, scene
from comparisons.stability.parts.ways import WAYS, chosen


def _boxes(direction: Scene) -> Scene:
    def box(z: float) -> Scene:
        geometry = {"shape": "box", "size": [1.0, 1.0, 1.0], "origin": [0.0, 0.0, z]}
        return body(geometry, (1, 1, 1), supports=[{"surface": "z_max" if z == 0 else "z_min"}])

    return scene(
        {"upper": box(0.0), "lower": box(-1.0)},
        contact=contact("upper.z_min", "lower.z_max", friction_direction_on_a=direction),
    )


_DIRECTIONS = {
    "one number in space": _boxes({"vector": [1.0]}),
    "two numbers in space": _boxes({"vector": [1.0, 0.0]}),
    "three numbers in the plane": layers(friction_direction_on_a={"vector": [1.0, 0.0, 0.0]}),
    "one number in the plane": layers(friction_direction_on_a={"vector": [1.0]}),
    "zero": layers(friction_direction_on_a={"vector": [0.0, 0.0]}),
    "normal to the contact": layers(friction_direction_on_a={"vector": [0.0, 1.0]}),
    "none": layers(friction_direction_on_a=None),
    "one expression in the plane": layers(friction_direction_on_a={"field": ["1"]}),
}


@case("Directions of friction that are none", subject="what is refused")
def directions() -> Iterator[Run]:
    """Each is refused, and its field named."""
    for name, data in _DIRECTIONS.items():
        for way in chosen(WAYS, "GPTS, penalty", "mortar, saddle"):
            problem = OfScene(way.of(data))
            yield Run(name, way, problem, None, REFUSED, names="friction_direction_on_a")
