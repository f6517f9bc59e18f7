"""Gauss-point-to-surface contact, half pass."""

from dataclasses import dataclass
from typing import Literal

from cea.body import Surface, SurfacePoints
from cea.errors import InputError


@dataclass(frozen=True)
class GaussPointToSurface:
    """Contact at Gauss points of side a (GPTS): Mohanasundaram et al. (2023), eqs. 36 and 37.

    Parameters
    ----------
    points
        Gauss points per direction in each surface element.
    lumped
        Whether the block of each side is summed onto its diagonal (eq. 41).
    """

    points: int
    lumped: bool = False
    method: Literal["gpts"] = "gpts"

    def __post_init__(self) -> None:
        if self.points < 1:
            raise InputError("points", self.points, "at least 1 per direction")

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.gauss_points(self.points)
