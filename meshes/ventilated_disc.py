"""A ventilated brake disc: two rings joined by vanes, the lower one on a hat with a hub plate."""

from dataclasses import dataclass
from math import asin, cos, pi, radians, sin, sqrt
from typing import ClassVar, Literal

from cea.errors import require
from meshes.simple_shapes import check_positive, check_rising


@dataclass(frozen=True)
class VentilatedDisc:
    """Ventilated disc about the z axis; the upper ring is held by the vanes alone.

    From the outside inwards: the lower ring and, above a gap, the upper one; straight radial vanes
    that fill the gap from ring to ring; an inner flange of the height of the lower ring; the wall
    of the hat, which rises from the bottom of the flange to the top of the hub plate; the hub
    plate with its bore and round holes. The faces of the rings that pads slide on are flat.

    Surfaces: bore; holes (all of them, if any); lower_face (z = 0, of ring, flange and wall) and
    upper_face (of the upper ring), on which pads slide; rim (the outer cylinder: of the rings, and
    the outer ends of the vanes); hub_top (of the plate and the wall).

    Parameters
    ----------
    bore
        Radius of the bore (m).
    wall_inner, wall_outer
        Radii of the wall of the hat (m).
    flange_outer
        Outer radius of the flange, where the rings begin (m).
    outer_radius
        Radius of the rings (m).
    ring_height
        Height of the lower ring, from z = 0, and of the flange (m).
    upper_bottom, upper_top
        z of the flat faces of the upper ring (m).
    hub_bottom, hub_top
        z of the flat faces of the hub plate (m).
    holes, hole_radius, hole_circle, hole_start
        How many holes, their radius and that of the circle of their centres (m), and the angle of
        the first (degrees).
    vanes, vane_width, vane_start
        How many vanes, their width (m), and the angle of the first (degrees).
    """

    bore: float = 0.04
    wall_inner: float = 0.105
    wall_outer: float = 0.1125
    flange_outer: float = 0.125
    outer_radius: float = 0.175
    ring_height: float = 0.010
    upper_bottom: float = 0.025
    upper_top: float = 0.035
    hub_bottom: float = 0.065
    hub_top: float = 0.075
    holes: int = 5
    hole_radius: float = 0.010
    hole_circle: float = 0.075
    hole_start: float = 18.0
    vanes: int = 21
    vane_width: float = 0.0287
    vane_start: float = 4.004
    shape: Literal["ventilated_disc"] = "ventilated_disc"

    directions: ClassVar[tuple[str, ...]] = ("r", "theta", "z")

    def __post_init__(self) -> None:
        check_positive(self, "bore")
        check_rising(self, "bore", "wall_inner", "wall_outer", "flange_outer", "outer_radius")
        check_positive(self, "ring_height")
        check_rising(self, "ring_height", "upper_bottom", "upper_top")
        check_rising(self, "ring_height", "hub_bottom", "hub_top")
        require(1 <= self.vanes <= _MOST, "vanes", self.vanes, f"1 to {_MOST}: they hold the ring")
        widest = 2 * self.flange_outer * sin(pi / max(self.vanes, 2))
        allowed = f"positive and less than {widest:.6g} (m), where vanes meet each other"
        require(0 < self.vane_width < widest, "vane_width", self.vane_width, allowed)
        require(0 <= self.holes <= _MOST, "holes", self.holes, f"0 to {_MOST}")
        if not self.holes:
            return
        room = min(self.hole_circle - self.bore, self.wall_inner - self.hole_circle)
        require(room > 0, "hole_circle", self.hole_circle, f"{self.bore} to {self.wall_inner} (m)")
        if self.holes > 1:
            room = min(room, self.hole_circle * sin(pi / self.holes))
        allowed = f"positive and less than {room:.6g} (m), where holes meet each other or an edge"
        require(0 < self.hole_radius < room, "hole_radius", self.hole_radius, allowed)

    @property
    def surfaces(self) -> tuple[str, ...]:
        """Names of its surfaces: holes only where there are any."""
        return ("bore", *["holes"] * bool(self.holes), "lower_face", "upper_face", "rim", "hub_top")

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction."""
        return (self.bore, self.outer_radius), (0.0, 360.0), (0.0, self.hub_top)

    @property
    def vane_angles(self) -> tuple[float, ...]:
        """Angles of the vanes from the x axis (rad)."""
        return _all_round(self.vanes, self.vane_start)

    @property
    def hole_centres(self) -> tuple[tuple[float, float], ...]:
        """Centres of the holes (m)."""
        angles = _all_round(self.holes, self.hole_start)
        return tuple((self.hole_circle * cos(t), self.hole_circle * sin(t)) for t in angles)

    @property
    def volume(self) -> float:
        """Volume (m^3) in closed form."""
        rings = _ring(self.flange_outer, self.outer_radius)
        width = self.vane_width
        vane = _strip(self.outer_radius, width) - _strip(self.flange_outer, width)
        plate = _ring(self.bore, self.wall_inner) - self.holes * pi * self.hole_radius**2
        return (
            rings * (self.ring_height + self.upper_top - self.upper_bottom)
            + self.vanes * vane * (self.upper_bottom - self.ring_height)
            + _ring(self.wall_outer, self.flange_outer) * self.ring_height
            + _ring(self.wall_inner, self.wall_outer) * self.hub_top
            + plate * (self.hub_top - self.hub_bottom)
        )

    @property
    def lengths(self) -> tuple[float, float, float]:
        """Lengths (m) of an equivalent plate: of its volume, as thick as the lower ring."""
        around = pi * (self.outer_radius + self.wall_inner)
        return self.volume / (around * self.ring_height), around, self.ring_height


MAX_CURVED = 2
"""Highest order of its curved cells."""
_MOST = 200
"""Largest number of holes, and of vanes."""


def _all_round(count: int, start: float) -> tuple[float, ...]:
    """Angles (rad) evenly spaced, the first at ``start`` degrees."""
    return tuple(radians(start) + 2 * pi * i / count for i in range(count))


def _ring(inner: float, outer: float) -> float:
    return pi * (outer**2 - inner**2)


def _strip(radius: float, width: float) -> float:
    """Area of the part of a half disc within half a width of its middle ray."""
    half = width / 2
    return half * sqrt(radius**2 - half**2) + radius**2 * asin(half / radius)
