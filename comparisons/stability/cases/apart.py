"""Sides of a contact that do not touch."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import changed, pad
from comparisons.stability.parts.ways import WAYS, chosen


@case("Sides of a contact 0.1 to 0.24 m apart", subject="geometry")
def apart() -> Iterator[Run]:
    """In truth they do not touch: a run that closes the gap must say so, or be refused."""
    for distance in (0.1, 0.24):
        for way in chosen(WAYS, "node", "Greville", "GPTS, penalty", "segments, penalty", "mortar"):
            data = way.of(changed(pad(1.0), {"bodies.pad.geometry.origin": [0.5, distance]}))
            yield Run(
                f"{distance:g} m apart",
                way,
                OfScene(data),
                dense({**data, "contacts": {}}),
                ("warned", "refused"),
            )
