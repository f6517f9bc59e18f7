"""Shapes in space: directions (x, y, z) or (r, theta, z), lengths in metres, angles in degrees."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.errors import require


@dataclass(frozen=True)
class Box:
    """Box with edges along x, y, z; surfaces x_min, x_max, y_min, y_max, z_min, z_max.

    Parameters
    ----------
    size
        Edge lengths (m).
    origin
        Corner of least coordinates (m).
    """

    size: tuple[float, float, float]
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shape: Literal["box"] = "box"

    directions: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    surfaces: ClassVar[tuple[str, ...]] = ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max")

    def __post_init__(self) -> None:
        require(all(s > 0 for s in self.size), "size", self.size, "three positive lengths (m)")

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction."""
        return tuple((o, o + s) for o, s in zip(self.origin, self.size, strict=True))


@dataclass(frozen=True)
class Annulus:
    """Full flat ring about the z axis; surfaces inner, outer, bottom, top.

    Its theta direction runs from 0 to 360 degrees and always has breaks at 0, 90, 180, 270: the
    joints of its four NURBS patches.

    Parameters
    ----------
    inner_radius, outer_radius
        Radii (m).
    bottom, top
        z of its flat faces (m).
    """

    inner_radius: float
    outer_radius: float
    bottom: float
    top: float
    shape: Literal["annulus"] = "annulus"

    directions: ClassVar[tuple[str, ...]] = ("r", "theta", "z")
    surfaces: ClassVar[tuple[str, ...]] = ("inner", "outer", "bottom", "top")

    def __post_init__(self) -> None:
        require(self.inner_radius > 0, "inner_radius", self.inner_radius, "a positive length (m)")
        require(
            self.outer_radius > self.inner_radius,
            "outer_radius",
            self.outer_radius,
            f"more than inner_radius = {self.inner_radius} (m)",
        )
        require(self.top > self.bottom, "top", self.top, f"more than bottom = {self.bottom} (m)")

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction."""
        return (self.inner_radius, self.outer_radius), (0.0, 360.0), (self.bottom, self.top)


@dataclass(frozen=True)
class Sector:
    """Part of a flat ring about the z axis; surfaces inner, outer, start, end, bottom, top.

    Parameters
    ----------
    inner_radius, outer_radius
        Radii (m).
    start, end
        Angles of its straight sides from the x axis (degrees), less than 180 apart.
    bottom, top
        z of its flat faces (m).
    """

    inner_radius: float
    outer_radius: float
    start: float
    end: float
    bottom: float
    top: float
    shape: Literal["sector"] = "sector"

    directions: ClassVar[tuple[str, ...]] = ("r", "theta", "z")
    surfaces: ClassVar[tuple[str, ...]] = ("inner", "outer", "start", "end", "bottom", "top")

    def __post_init__(self) -> None:
        Annulus(self.inner_radius, self.outer_radius, self.bottom, self.top)
        require(
            0 < self.end - self.start < 180,
            "end",
            self.end,
            f"more than start = {self.start}, by less than 180 degrees",
        )

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction."""
        return (
            (self.inner_radius, self.outer_radius),
            (self.start, self.end),
            (self.bottom, self.top),
        )


@dataclass(frozen=True)
class Hub:
    """Flat ring on a thicker hub about the z axis; plane or curved faces all named.

    The hub reaches from ``bore`` to ``hub_radius`` and stands out of the ring on one or both sides.
    Surfaces: bore (inner cylinder), hub_bottom and hub_top (flat ends of the hub), bottom and top
    (flat faces of the ring), outer (rim of the ring). The cylinder of the hub that stands out is
    hub_side.

    Parameters
    ----------
    bore, hub_radius, outer_radius
        Radii (m), rising.
    bottom, top
        z of the flat faces of the ring (m).
    hub_bottom, hub_top
        z of the ends of the hub (m), not inside the ring.
    """

    bore: float
    hub_radius: float
    outer_radius: float
    bottom: float
    top: float
    hub_bottom: float
    hub_top: float
    shape: Literal["hub"] = "hub"

    directions: ClassVar[tuple[str, ...]] = ("r", "theta", "z")
    surfaces: ClassVar[tuple[str, ...]] = (
        "bore", "outer", "bottom", "top", "hub_bottom", "hub_top", "hub_side",
    )  # fmt: skip

    def __post_init__(self) -> None:
        Annulus(self.bore, self.hub_radius, self.hub_bottom, self.hub_top)
        Annulus(self.hub_radius, self.outer_radius, self.bottom, self.top)
        require(
            self.hub_bottom <= self.bottom, "hub_bottom", self.hub_bottom, f"{self.bottom} or less"
        )
        require(self.hub_top >= self.top, "hub_top", self.hub_top, f"{self.top} or more")
        require(
            self.hub_bottom < self.bottom or self.hub_top > self.top,
            "hub_top",
            self.hub_top,
            "a hub that stands out of the ring on one side at least",
        )

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction."""
        return (self.bore, self.outer_radius), (0.0, 360.0), (self.hub_bottom, self.hub_top)


@dataclass(frozen=True)
class Disc:
    """Full round plate without a hole about the z axis; surfaces outer, bottom, top.

    Parameters
    ----------
    outer_radius
        Radius (m).
    bottom, top
        z of its flat faces (m).
    """

    outer_radius: float
    bottom: float
    top: float
    shape: Literal["disc"] = "disc"

    directions: ClassVar[tuple[str, ...]] = ("r", "theta", "z")
    surfaces: ClassVar[tuple[str, ...]] = ("outer", "bottom", "top")

    def __post_init__(self) -> None:
        require(self.outer_radius > 0, "outer_radius", self.outer_radius, "a positive length (m)")
        require(self.top > self.bottom, "top", self.top, f"more than bottom = {self.bottom} (m)")

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction."""
        return (0.0, self.outer_radius), (0.0, 360.0), (self.bottom, self.top)
