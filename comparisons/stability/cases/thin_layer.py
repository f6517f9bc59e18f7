"""A layer in contact that is far thinner than long."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import WAYS, chosen


@case("A layer in contact, thickness 1e-3 to 1e-5 of its length", subject="geometry")
def thin_layer() -> Iterator[Run]:
    """Elements are as flat as the layer; its normal stiffness is E over its thickness."""
    for height in (2e-3, 2e-4, 2e-5):
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
            data = way.of(layers(height=height))
            yield Run(
                f"thickness {height / 2:.0e} of the length",
                way,
                OfScene(data),
                dense(data),
                tolerance=1e-7,
            )
