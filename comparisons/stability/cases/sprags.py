"""Sprags: blocks that friction drives into their base."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import sprag
from comparisons.stability.parts.ways import WAYS


@case("Sprags: divergence and flutter at any friction", subject="friction and spectra")
def sprags() -> Iterator[Run]:
    """A mode that grows without oscillating lies far from those that oscillate slowly."""
    for angle, mu in ((60.0, 0.3), (60.0, 0.7), (60.0, 2.0), (80.0, 0.5), (80.0, 5.0)):
        for p in (1.0, 1e4):
            for way in WAYS:
                data = way.of(sprag(angle, mu, p=p))
                row = f"{angle:g} degrees, μ = {mu:g}, p = {p:.0e}"
                yield Run(row, way, OfScene(data), dense(data), lowest=6)
