"""Meshes of very different fineness on both sides of a contact."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import WAYS


@case("Mesh ratio 1 to 50 across the contact, both ways", subject="geometry")
def mesh_ratio() -> Iterator[Run]:
    """Each side the coarser one in turn."""
    for upper, lower in ((1, 50), (50, 1)):
        for way in WAYS:
            data = way.of(layers(upper_elements=(upper, 1), lower_elements=(lower, 1)))
            yield Run(
                f"{upper} element on {lower}" if upper == 1 else f"{upper} elements on {lower}",
                way,
                OfScene(data),
                dense(data),
            )
