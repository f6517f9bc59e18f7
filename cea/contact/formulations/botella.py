"""Collocation at the maxima of B-splines."""

from dataclasses import dataclass
from typing import Literal

from cea.body import Surface, SurfacePoints


@dataclass(frozen=True)
class Botella:
    """Contact collocated at the maxima of the B-splines of side a (Botella 2002).

    Parameters
    ----------
    weights
        ``equal``: each point bears the same share of the area. ``area``: the integral of its
        trace function (Matzen & Bischoff 2016).
    """

    weights: Literal["equal", "area"] = "equal"
    method: Literal["botella"] = "botella"

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.abscissae("botella", self.weights)
