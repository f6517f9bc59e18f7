"""Shapes a scene can name, their placement in space, and where their element boundaries lie.

Each shape has three directions with physical coordinates, (x, y, z) or (r, theta, z), lengths in
metres and angles in degrees. Both builders divide a shape by *breaks*: rising coordinates of the
element boundaries along each direction, both ends included.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]
Breaks = tuple[Floats, ...]


class ShapeError(ValueError):
    """Geometry refused before anything is built.

    Parameters
    ----------
    field
        Name of the offending field.
    value
        The value that was given.
    allowed
        What is allowed, in words.
    """

    def __init__(self, field: str, value: object, allowed: str) -> None:
        self.field = field
        self.value = value
        self.allowed = allowed
        super().__init__(f"{field} = {value!r}: {allowed}")


def require(condition: bool, field: str, value: object, allowed: str) -> None:
    """Raise :class:`ShapeError` unless a condition holds."""
    if not condition:
        raise ShapeError(field, value, allowed)


@dataclass(frozen=True)
class Placement:
    """Rotation about an axis through the origin, then a translation.

    Parameters
    ----------
    axis
        Rotation axis, any length but zero.
    angle
        Rotation angle (degrees).
    translation
        Translation (m).
    """

    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    angle: float = 0.0
    translation: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        require(bool(np.linalg.norm(self.axis) > 0), "axis", self.axis, "a vector that is not zero")

    @property
    def rotation(self) -> Floats:
        """Rotation matrix, (3, 3)."""
        axis = np.asarray(self.axis, dtype=float)
        return Rotation.from_rotvec(
            axis / np.linalg.norm(axis) * self.angle, degrees=True
        ).as_matrix()

    def apply(self, points: Floats) -> Floats:
        """Placed copies of points (m), shape (..., 3)."""
        return points @ self.rotation.T + np.asarray(self.translation)


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

    directions: ClassVar[tuple[str, str, str]] = ("x", "y", "z")
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

    directions: ClassVar[tuple[str, str, str]] = ("r", "theta", "z")
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

    directions: ClassVar[tuple[str, str, str]] = ("r", "theta", "z")
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


Shape = Box | Annulus | Sector


def spread(low: float, high: float, count: int, through: Sequence[float] = ()) -> Floats:
    """Element boundaries as even as possible that pass through given coordinates.

    Parameters
    ----------
    low, high
        Ends of the range.
    count
        Number of elements, at least one for each stretch between asked coordinates.
    through
        Coordinates that must be element boundaries.

    Returns
    -------
    ndarray
        ``count + 1`` rising coordinates.
    """
    stops = np.unique(np.concatenate([[low, high], np.asarray(through, dtype=float)]))
    require(
        bool(stops[0] == low and stops[-1] == high), "through", list(through), f"{low} to {high}"
    )
    require(count >= len(stops) - 1, "count", count, f"at least {len(stops) - 1} elements")
    shares = np.ones(len(stops) - 1, dtype=int)
    lengths = np.diff(stops)
    for _ in range(count - len(shares)):
        shares[np.argmax(lengths / shares)] += 1
    pieces = [
        np.linspace(a, b, n + 1)[:-1] for (a, b), n in zip(pairwise(stops), shares, strict=True)
    ]
    return np.concatenate([*pieces, [high]])


def breaks_of(
    shape: Shape,
    elements: tuple[int, int, int],
    through: Mapping[str, Sequence[float]] | None = None,
) -> Breaks:
    """Breaks of a shape along its three directions.

    Parameters
    ----------
    shape
        The shape.
    elements
        Number of elements along each direction; of an annulus, all the way round.
    through
        Coordinates that must be breaks, by name of the direction.
    """
    asked = {name: list(values) for name, values in (through or {}).items()}
    unknown = set(asked) - set(shape.directions)
    require(not unknown, "through", sorted(unknown), f"directions {', '.join(shape.directions)}")
    if isinstance(shape, Annulus):
        asked["theta"] = [*asked.get("theta", []), 90.0, 180.0, 270.0]
    return tuple(
        spread(low, high, count, asked.get(name, ()))
        for name, (low, high), count in zip(shape.directions, shape.extent, elements, strict=True)
    )
