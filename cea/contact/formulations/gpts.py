"""Gauss-point-to-surface contact, half pass."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.contact.coupling import Coupling
from cea.contact.formulations.base import Formulation, check_points, register
from cea.surface import Surface
from cea.surface_points import SurfacePoints


@register
@dataclass(frozen=True)
class GaussPointToSurface(Formulation):
    """Contact at Gauss points of side a (GPTS): Mohanasundaram et al. (2023), eqs. 36 and 37.

    Parameters
    ----------
    points
        Gauss points per direction in each surface element.
    lumped
        Whether the block of each side is summed onto its diagonal (eq. 41).
    """

    name: ClassVar[str] = "GPTS"

    points: int
    lumped: bool = False
    method: Literal["gpts"] = "gpts"

    def __post_init__(self) -> None:
        check_points(self.points)

    @property
    def coupling(self) -> Coupling:
        """Lumped, or a penalty at each point."""
        return "lumped" if self.lumped else "pointwise"

    @property
    def options(self) -> tuple[str, ...]:
        """Whether it is lumped."""
        return ("lumped",) if self.lumped else ()

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.gauss_points(self.points)
