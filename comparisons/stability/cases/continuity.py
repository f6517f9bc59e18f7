"""Splines from continuity 0 to the highest their degree has."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import changed, layers
from comparisons.stability.parts.ways import WAYS, chosen


@case("Continuity 0 to p - 1 of splines", subject="elements and splines")
def continuity() -> Iterator[Run]:
    """Collocation points crowd at knots of low continuity."""
    for degree in (2, 4):
        for smooth in range(degree):
            fields = {"degree": degree}
            mesh = {
                f"bodies.{name}.mesh.iga.continuity": [smooth] * 2 for name in ("upper", "lower")
            }
            scene = changed(
                layers(upper=fields, lower=fields, upper_elements=(3, 1), lower_elements=(2, 2)),
                mesh,
            )
            for way in chosen(WAYS, backend="iga"):
                data = way.of(scene)
                yield Run(f"degree {degree}, C{smooth}", way, OfScene(data), dense(data))
