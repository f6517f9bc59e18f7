"""Node-to-surface contact."""

from dataclasses import dataclass
from typing import Literal

from cea.body import Surface, SurfacePoints


@dataclass(frozen=True)
class NodeToSurface:
    """Contact at the interpolation nodes of side a, each with the same share of the area."""

    method: Literal["node_to_surface"] = "node_to_surface"

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.abscissae("nodes")
