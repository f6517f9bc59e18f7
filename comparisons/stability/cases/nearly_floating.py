"""A body that nothing holds but a contact that is next to nothing."""

from collections.abc import Iterator

from comparisons.stability.parts.case import MESH, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import Scene, body, contact, rectangle, scene
from comparisons.stability.parts.ways import WAYS, chosen


def _floating(p: float) -> Scene:
    return scene(
        {
            "upper": body(rectangle((1.0, 0.5), (0.5, 0.0)), (3, 2)),
            "lower": body(
                rectangle((2.0, 1.0), (0.0, -1.0)), (4, 2), supports=[{"surface": "y_min"}]
            ),
        },
        contact=contact("upper.y_min", "lower.y_max", p=p),
    )


@case("A block held by a contact of p = 1e-2 to 1e-12 N/m³", subject="contact stiffness")
def nearly_floating() -> Iterator[Run]:
    """It slides freely, and bounces on the contact as slowly as that is soft."""
    for p in (1e-2, 1e-6, 1e-12):
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
            data = way.of(_floating(p))
            row, may = f"p = {p:.0e} N/m³", (*MESH, "undecided") if p == 1e-12 else MESH
            yield Run(row, way, OfScene(data), dense(data), tolerance=1e-7, warnings=may)
