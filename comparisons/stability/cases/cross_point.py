"""Four blocks round a point: constraints that depend on each other."""

from collections.abc import Iterator
from math import inf

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import benign, dense
from comparisons.stability.parts.scenes import Scene, body, contact, rectangle, scene
from comparisons.stability.parts.ways import SADDLE, chosen

_GROUND = [{"surface": "y_min"}]


def _four(P: float) -> Scene:
    """Two blocks that rub, two on top of them bonded to them and to each other."""

    def block(x: float, y: float, *supports: Scene) -> Scene:
        return body(rectangle((1.0, 1.0), (x, y)), (4, 4), supports=supports)

    def bond(a: str, b: str) -> Scene:
        return contact(a, b, formulation={"method": "bonded"}, form="saddle", mu=0.0, P=P)

    return scene(
        {
            "b0": block(0.0, 0.0, *_GROUND),
            "b1": block(1.0, 0.0, *_GROUND),
            "b2": block(1.0, 1.0),
            "b3": block(0.0, 1.0),
        },
        rub=contact(
            "b0.x_max", "b1.x_min", P=P, mu=0.4, friction_direction_on_a={"vector": [0.0, 1.0]}
        ),
        right=bond("b1.y_max", "b2.y_min"),
        top=bond("b2.x_min", "b3.x_max"),
        left=bond("b3.y_min", "b0.y_max"),
    )


@case("Four blocks tied round a cross point", subject="contact stiffness")
def cross_point() -> Iterator[Run]:
    """Ties that meet in a point are counted once; from P = 1e14 on nothing changes."""
    for P in (1e4, 1e14, 1e20, inf):
        for way in chosen(SADDLE, "mortar", "GPTS, saddle"):
            data = way.of(_four(P))
            yield Run(f"P = {P:.0e}", way, OfScene(data), dense(data), lowest=6)
    for way in chosen(SADDLE, "mortar"):
        yield Run(
            "P = 1e20, as at 1e14",
            way,
            OfScene(way.of(_four(1e20))),
            benign(way.of(_four(1e14))),
            tolerance=1e-7,
            lowest=6,
        )
