"""Collocation on a grid of equally spaced points."""

from dataclasses import dataclass
from typing import Literal

from cea.body import Surface, SurfacePoints
from cea.errors import InputError


@dataclass(frozen=True)
class Grid:
    """Contact collocated at equally spaced points of side a, each with the same share of the area.

    Parameters
    ----------
    points
        Points per direction over each NURBS face, or per side of each facet of a mesh; both
        include the boundary.
    """

    points: int
    method: Literal["grid"] = "grid"

    def __post_init__(self) -> None:
        if self.points < 2:
            raise InputError("points", self.points, "at least 2 per direction")

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.grid(self.points)
