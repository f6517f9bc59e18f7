"""Sectors of a tenth of a degree in contact."""

from collections.abc import Iterator
from typing import Any

from comparisons.stability.parts.case import ACCURATE, WARNED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import Scene, body, contact, scene
from comparisons.stability.parts.ways import WAYS, chosen


def _sectors(degrees: float, **fields: Any) -> Scene:
    """One sector round another."""

    def sector(inner: float, outer: float, held: str) -> Scene:
        geometry = {
            "shape": "ring_sector",
            "inner_radius": inner,
            "outer_radius": outer,
            "start": 30.0,
            "end": 30.0 + degrees,
        }
        return body(geometry, (2, 3 if held == "outer" else 2), supports=[{"surface": held}])

    return scene(
        {"outer": sector(1.0, 1.5, "outer"), "inner": sector(0.5, 1.0, "inner")},
        contact=contact("outer.inner", "inner.outer", **fields),
    )


@case("Sectors of 90 to 0.1 degrees", subject="geometry")
def narrow_sector() -> Iterator[Run]:
    """At 0.1 degrees they are columns, 290 times longer than wide: digits of bending are lost."""
    about = {"friction_direction_on_a": {"circumferential_about": [0.0, 0.0, 1.0]}}
    for degrees in (90.0, 1.0, 0.1):
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
            data = way.of(_sectors(degrees, **about))
            row = f"{degrees:g} degrees"
            if degrees < 1:
                yield Run(row, way, OfScene(data), dense(data), WARNED, tolerance=1e-6)
            else:
                yield Run(row, way, OfScene(data), dense(data), ACCURATE)
