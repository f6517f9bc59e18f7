"""Collocation at the maxima of B-splines."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.contact.formulations.base import Formulation, register
from cea.surface import Surface
from cea.surface_points import SurfacePoints


@register
@dataclass(frozen=True)
class Botella(Formulation):
    """Contact collocated at the maxima of the B-splines of side a (Botella 2002).

    Parameters
    ----------
    weights
        ``equal``: each point bears the same share of the area of its smooth part. ``area``: the
        integral of its trace function (Matzen & Bischoff 2016).
    """

    name: ClassVar[str] = "Botella"
    abscissae: ClassVar[str | None] = "botella"

    weights: Literal["equal", "area"] = "equal"
    method: Literal["botella"] = "botella"

    @property
    def options(self) -> tuple[str, ...]:
        """The weights, where they are not equal."""
        return () if self.weights == "equal" else (self.weights,)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.abscissae("botella", self.weights)
