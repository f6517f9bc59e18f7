"""Densities that differ by powers of ten across a contact."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import WAYS, chosen


@case("Density of side a 1e-4 to 1e4 times that of side b", subject="materials and units")
def density_contrast() -> Iterator[Run]:
    """Heavy on light, and light on heavy."""
    for ratio in (1e-4, 1e-2, 1e2, 1e4):
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
            data = way.of(layers(upper={"E": 1.0, "rho": ratio}))
            yield Run(f"density ratio {ratio:.0e}", way, OfScene(data), dense(data))
