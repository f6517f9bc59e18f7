"""Node-to-surface contact."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.contact.formulations.base import Formulation, register
from cea.surface import Surface
from cea.surface_points import SurfacePoints


@register
@dataclass(frozen=True)
class NodeToSurface(Formulation):
    """Contact at the interpolation nodes of side a, at a corner once for each face.

    Parameters
    ----------
    weights
        ``equal``: each node bears the same share of the area of its smooth part. ``tributary``:
        each facet's area shared among its nodes in proportion to int N_i^2. Integrals of N_i are
        no weights: they vanish at corners of quadratic triangles.
    """

    name: ClassVar[str] = "node-to-surface"
    abscissae: ClassVar[str | None] = "nodes"

    weights: Literal["equal", "tributary"] = "equal"
    method: Literal["node_to_surface"] = "node_to_surface"

    @property
    def options(self) -> tuple[str, ...]:
        """The weights, where they are not equal."""
        return () if self.weights == "equal" else (self.weights,)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.abscissae("nodes", self.weights)
