"""The same scene far from the origin of its coordinates."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import benign
from comparisons.stability.parts.scenes import layers, moved, pad
from comparisons.stability.parts.ways import WAYS


@case("The origin 1e3 and 1e6 m away", subject="geometry")
def far_origin() -> Iterator[Run]:
    """Coordinates have ten digits less 1e6 m away: eigenvalues keep those that remain."""
    scenes = {"layers": layers(), "pad": pad(max_missed=0.6)}
    for away, tolerance in ((1e3, 1e-9), (1e6, 1e-6)):
        for name, scene in scenes.items():
            for way in WAYS:
                data = way.of(moved(scene, (away, -away)))
                yield Run(
                    f"{name} {away:.0e} m away",
                    way,
                    OfScene(data),
                    benign(way.of(scene)),
                    tolerance=tolerance,
                )
