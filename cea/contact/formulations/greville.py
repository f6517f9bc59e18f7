"""Collocation at Greville abscissae."""

from dataclasses import dataclass
from typing import Literal

from cea.body import Surface, SurfacePoints


@dataclass(frozen=True)
class Greville:
    """Contact collocated at the Greville abscissae of side a.

    Parameters
    ----------
    weights
        ``equal``: each point carries the stiffness P / n_points (Mohanasundaram et al. 2023,
        section 3). ``area``: the integral of its trace function (Matzen & Bischoff 2016).
    """

    weights: Literal["equal", "area"] = "equal"
    method: Literal["greville"] = "greville"

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.abscissae("greville", self.weights)
