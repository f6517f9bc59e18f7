"""Exact integration of the penalty form."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.contact.formulations.base import Formulation, check_points, register
from cea.surface import Surface
from cea.surface_points import SurfacePoints


@dataclass(frozen=True)
class OnSegments(Formulation):
    """What formulations share whose quadrature is the common refinement of both surface meshes.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None takes what is exact on flat interfaces.
    """

    points: int | None = None

    def __post_init__(self) -> None:
        if self.points is not None:
            check_points(self.points)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        from cea.contact.segments import segment_points  # brings shapely and scipy.spatial

        return segment_points(a, b, self.points, reach)


@register
@dataclass(frozen=True)
class Segments(OnSegments):
    """Contact at Gauss points on the common refinement of both surface meshes.

    The exact integral of the penalty form on flat interfaces: the yardstick of quadrature. It
    enforces the gap at more points than side a has dofs, and locks as p grows.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None takes what is exact on flat interfaces.
    """

    name: ClassVar[str] = "segments"

    method: Literal["segments"] = "segments"
