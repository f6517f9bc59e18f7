"""Young's moduli that differ by powers of ten across a contact."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import WAYS, chosen


@case("Young's modulus of side a 1e-6 to 1e6 times that of side b", subject="materials and units")
def elastic_contrast() -> Iterator[Run]:
    """The contact is as stiff as the softer side."""
    for ratio in (1e-6, 1e-3, 1e3, 1e6):
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
            data = way.of(layers(p=min(ratio, 1.0), upper={"E": ratio, "rho": 1.0}))
            yield Run(f"E ratio {ratio:.0e}", way, OfScene(data), dense(data))
