"""Node-to-surface contact."""

from dataclasses import dataclass
from typing import Literal

from cea.body import Surface, SurfacePoints


@dataclass(frozen=True)
class NodeToSurface:
    """Contact at the interpolation nodes of side a.

    Parameters
    ----------
    weights
        ``equal``: each node bears the same share of the area. ``tributary``: each facet's area
        shared among its nodes in proportion to int N_i^2. Integrals of N_i are no weights: they
        vanish at corners of quadratic triangles.
    """

    weights: Literal["equal", "tributary"] = "equal"
    method: Literal["node_to_surface"] = "node_to_surface"

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.abscissae("nodes", self.weights)
