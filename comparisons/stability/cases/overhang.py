"""A pad that hangs over the edge of its base."""

from collections.abc import Iterator

from comparisons.stability.parts.case import MESH, REFUSED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import pad
from comparisons.stability.parts.ways import WAYS, chosen


@case("A pad over the edge of its base", subject="geometry")
def overhang() -> Iterator[Run]:
    """Points that find nothing are refused, or counted where the scene allows them."""
    ways = chosen(
        tuple(way for way in WAYS if "full pass" not in way.name),
        *("node", "Greville", "GPTS", "segments", "mortar"),
    )
    for way in ways:
        data = way.of(pad(0.5, 1.75))
        yield Run("half of it, not allowed", way, OfScene(data), None, REFUSED, names="contact")
    for way in ways:
        data = way.of(pad(0.5, 1.75, max_missed=0.6))
        said = (*MESH, "partly-uncovered")
        yield Run("half of it, allowed", way, OfScene(data), dense(data), warnings=said)
