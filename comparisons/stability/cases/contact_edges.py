"""Edges of a contact inside elements of the other side, and contact on a single element."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import pad
from comparisons.stability.parts.ways import WAYS, chosen

_PADS = {
    "edges inside elements": (0.5, 0.63, (3, 2)),
    "on one element": (0.1, 0.85, (3, 2)),
    "one element on one": (0.1, 0.85, (1, 1)),
    "edge on an edge": (0.4, 0.8, (2, 2)),
    "edge almost on an edge": (0.4, 0.8 - 1e-13, (2, 2)),
}
"""Width of the pad, x of its left edge, its elements; those of the base end at 0.4, 0.8, ..."""


@case("Edges of the contact inside elements, contact on one element", subject="geometry")
def contact_edges() -> Iterator[Run]:
    """A pad that ends anywhere on its base."""
    half_passes = tuple(way for way in WAYS if "full pass" not in way.name)
    for name, (width, at, elements) in _PADS.items():
        for way in chosen(half_passes):
            data = way.of(pad(width, at, pad_elements=elements))
            yield Run(name, way, OfScene(data), dense(data))
