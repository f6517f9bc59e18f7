"""Collocation at Greville abscissae."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.contact.formulations.base import Formulation, register
from cea.surface import Surface
from cea.surface_points import SurfacePoints


@register
@dataclass(frozen=True)
class Greville(Formulation):
    """Contact collocated at the Greville abscissae of side a, at a corner once for each face.

    Parameters
    ----------
    weights
        ``equal``: each point carries the stiffness P / n_points of its smooth part
        (Mohanasundaram et al. 2023, section 3). ``area``: the integral of its trace function
        (Matzen & Bischoff 2016).
    """

    name: ClassVar[str] = "Greville"
    abscissae: ClassVar[str | None] = "greville"

    weights: Literal["equal", "area"] = "equal"
    method: Literal["greville"] = "greville"

    @property
    def options(self) -> tuple[str, ...]:
        """The weights, where they are not equal."""
        return () if self.weights == "equal" else (self.weights,)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.abscissae("greville", self.weights)
