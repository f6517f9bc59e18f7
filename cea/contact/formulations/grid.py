"""Collocation on a grid of equally spaced points."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.contact.formulations.base import Formulation, check_points, register
from cea.surface import Surface
from cea.surface_points import SurfacePoints


@register
@dataclass(frozen=True)
class Grid(Formulation):
    """Contact collocated at equally spaced points of side a.

    Each has the same share of the area of its smooth part.

    Parameters
    ----------
    points
        Points per direction over each NURBS face, or per side of each facet of a mesh; both
        include the boundary.
    """

    name: ClassVar[str] = "grid"

    points: int
    method: Literal["grid"] = "grid"

    def __post_init__(self) -> None:
        check_points(self.points, least=2)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.grid(self.points)
