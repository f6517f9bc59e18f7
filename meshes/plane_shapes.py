"""Shapes in plane strain: directions (x, y) or (r, theta), lengths in metres, angles in degrees."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.errors import require
from meshes.solid_shapes import Annulus, Sector


@dataclass(frozen=True)
class Rectangle:
    """Rectangle in plane strain; curves x_min, x_max, y_min, y_max.

    Parameters
    ----------
    size
        Edge lengths (m).
    origin
        Corner of least coordinates (m).
    """

    size: tuple[float, float]
    origin: tuple[float, float] = (0.0, 0.0)
    shape: Literal["rectangle"] = "rectangle"

    directions: ClassVar[tuple[str, ...]] = ("x", "y")
    surfaces: ClassVar[tuple[str, ...]] = ("x_min", "x_max", "y_min", "y_max")

    def __post_init__(self) -> None:
        require(all(s > 0 for s in self.size), "size", self.size, "two positive lengths (m)")

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction."""
        return tuple((o, o + s) for o, s in zip(self.origin, self.size, strict=True))


@dataclass(frozen=True)
class Ring:
    """Full ring in plane strain about the origin; curves inner, outer.

    Parameters
    ----------
    inner_radius, outer_radius
        Radii (m).
    """

    inner_radius: float
    outer_radius: float
    shape: Literal["ring"] = "ring"

    directions: ClassVar[tuple[str, ...]] = ("r", "theta")
    surfaces: ClassVar[tuple[str, ...]] = ("inner", "outer")

    def __post_init__(self) -> None:
        Annulus(self.inner_radius, self.outer_radius, 0.0, 1.0)

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction."""
        return (self.inner_radius, self.outer_radius), (0.0, 360.0)


@dataclass(frozen=True)
class RingSector:
    """Part of a ring in plane strain about the origin; curves inner, outer, start, end.

    Parameters
    ----------
    inner_radius, outer_radius
        Radii (m).
    start, end
        Angles of its straight sides from the x axis (degrees), less than 180 apart.
    """

    inner_radius: float
    outer_radius: float
    start: float
    end: float
    shape: Literal["ring_sector"] = "ring_sector"

    directions: ClassVar[tuple[str, ...]] = ("r", "theta")
    surfaces: ClassVar[tuple[str, ...]] = ("inner", "outer", "start", "end")

    def __post_init__(self) -> None:
        Sector(self.inner_radius, self.outer_radius, self.start, self.end, 0.0, 1.0)

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction."""
        return (self.inner_radius, self.outer_radius), (self.start, self.end)
