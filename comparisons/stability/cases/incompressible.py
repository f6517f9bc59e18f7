"""Poisson's ratios up to next to a half."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import WAYS, chosen


@case("Poisson's ratio 0 to 0.49999: the algebra", subject="materials and units")
def incompressible() -> Iterator[Run]:
    """What is assembled is solved, however stiff it is in volume; that it locks may be said."""
    for nu in (0.0, 0.49, 0.499, 0.4999, 0.49999):
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
            data = way.of(layers(upper={"nu": nu}, lower={"nu": nu}))
            yield Run(f"ν = {nu}", way, OfScene(data), dense(data))
