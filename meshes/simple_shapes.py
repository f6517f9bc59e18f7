"""Boxes and round shapes in space and in plane strain.

Directions are (x, y, z) or (r, theta, z) in space, (x, y) or (r, theta) in plane strain; lengths in
metres, angles in degrees.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar, Literal

from cea.errors import require

Extent = tuple[tuple[float, float], ...]
"""Range of the coordinate along each direction of a shape."""


def check_rising(shape: Any, *names: str) -> None:
    """Refuse lengths of a shape that do not increase from one of the fields to the next."""
    for lower, name in pairwise(names):
        least, value = getattr(shape, lower), getattr(shape, name)
        require(value > least, name, value, f"more than {lower} = {least} (m)")


def check_positive(shape: Any, name: str) -> None:
    """Refuse a length of a shape that is not positive."""
    value = getattr(shape, name)
    require(value > 0, name, value, "a positive length (m)")


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
    def extent(self) -> Extent:
        """Range of each coordinate."""
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
        check_positive(self, "inner_radius")
        check_rising(self, "inner_radius", "outer_radius")
        check_rising(self, "bottom", "top")

    @property
    def extent(self) -> Extent:
        """Range of each coordinate."""
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
        allowed = f"more than start = {self.start}, by less than 180 degrees"
        require(0 < self.end - self.start < 180, "end", self.end, allowed)

    @property
    def extent(self) -> Extent:
        """Range of each coordinate."""
        radii, heights = (self.inner_radius, self.outer_radius), (self.bottom, self.top)
        return radii, (self.start, self.end), heights


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
        "bore",
        "outer",
        "bottom",
        "top",
        "hub_bottom",
        "hub_top",
        "hub_side",
    )

    def __post_init__(self) -> None:
        check_positive(self, "bore")
        check_rising(self, "bore", "hub_radius", "outer_radius")
        check_rising(self, "hub_bottom", "hub_top")
        check_rising(self, "bottom", "top")
        below, above = self.bottom - self.hub_bottom, self.hub_top - self.top
        require(below >= 0, "hub_bottom", self.hub_bottom, f"{self.bottom} or less")
        require(above >= 0, "hub_top", self.hub_top, f"{self.top} or more")
        allowed = "a hub that stands out of the ring on one side at least"
        require(below > 0 or above > 0, "hub_top", self.hub_top, allowed)

    @property
    def extent(self) -> Extent:
        """Range of each coordinate."""
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
        check_positive(self, "outer_radius")
        check_rising(self, "bottom", "top")

    @property
    def extent(self) -> Extent:
        """Range of each coordinate."""
        return (0.0, self.outer_radius), (0.0, 360.0), (self.bottom, self.top)


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
    def extent(self) -> Extent:
        """Range of each coordinate."""
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
    def extent(self) -> Extent:
        """Range of each coordinate."""
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
    def extent(self) -> Extent:
        """Range of each coordinate."""
        return (self.inner_radius, self.outer_radius), (self.start, self.end)


def round_surfaces(shape: Any) -> dict[str, float]:
    """Radii (m) of the cylinders about z, or circles, that bound a shape, by surface."""
    if isinstance(shape, Hub):
        return {"bore": shape.bore, "hub_side": shape.hub_radius, "outer": shape.outer_radius}
    if isinstance(shape, Disc):
        return {"outer": shape.outer_radius}
    if isinstance(shape, Annulus | Sector | Ring | RingSector):
        return {"inner": shape.inner_radius, "outer": shape.outer_radius}
    return {}
