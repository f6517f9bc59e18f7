"""Shapes of which one flat face is crowned: it falls away from an apex as a paraboloid does.

At the distance s from the apex along a direction with the radius of curvature R the face lies
s^2 / (2 R) deeper in the body, as in the theory of Hertz; a cylinder or a sphere of radius R
deviates from this face by s^4 / (8 R^3). Along theta, s is the straight distance from the point of
equal radius at the apex: its square is a rational function of the arc, so that NURBS represent the
face exactly. Points behind the face move with it in proportion.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field
from scipy.special import comb

from cea.arrays import Floats
from cea.errors import InputError, require
from meshes.simple_shapes import Box, Rectangle, Sector


@dataclass(frozen=True)
class Crowned:
    """A box, rectangle or sector with one crowned face; it keeps their directions and surfaces.

    Parameters
    ----------
    base
        The shape before its face is crowned; coordinates of elements along its directions refer
        to it, too.
    surface
        The crowned face: any one of a box or rectangle, bottom or top of a sector.
    radii
        Radius of curvature at the apex (m) along one or both directions of the face, by name of
        the direction; along others the face stays straight.
    apex
        Coordinate (m, degrees) at which the face keeps its place, by name of the direction; in the
        middle by default.

    Raises
    ------
    InputError
        When a direction does not lie in the face, a radius is not positive, the apex lies outside
        the face, or the face falls through the body.
    """

    base: Annotated[Box | Rectangle | Sector, Field(discriminator="shape")]
    surface: str
    radii: dict[str, float]
    apex: dict[str, float] = field(default_factory=dict)
    shape: Literal["crowned"] = "crowned"

    flat: ClassVar[tuple[str, ...]] = ("bottom", "top")
    """Faces of a sector that can be crowned."""

    def __post_init__(self) -> None:
        faces = self.flat if isinstance(self.base, Sector) else self.base.surfaces
        require(self.surface in faces, "surface", self.surface, f"one of {', '.join(faces)}")
        within = [name for name in self.directions if name != self.directions[self.across]]
        extent = dict(zip(self.directions, self.extent, strict=True))
        require(bool(self.radii), "radii", self.radii, f"a radius along {' or '.join(within)}")
        for name, radius in self.radii.items():
            require(name in within, "radii", name, " or ".join(within))
            require(radius > 0, f"radii[{name}]", radius, "a positive length (m)")
        for name, place in self.apex.items():
            require(name in self.radii, "apex", name, f"one of {', '.join(self.radii)}, as radii")
            low, high = extent[name]
            require(low <= place <= high, f"apex[{name}]", place, f"{low} to {high}")
        low, high = self.extent[self.across]
        if not self.fall < high - low:
            largest = f"radii with which the face falls by less than {high - low:g} m"
            raise InputError("radii", self.radii, f"{largest}: it falls by {self.fall:g} m")

    @property
    def directions(self) -> tuple[str, ...]:
        """Names of the directions."""
        return self.base.directions

    @property
    def surfaces(self) -> tuple[str, ...]:
        """Names of the surfaces."""
        return self.base.surfaces

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the coordinate along each direction, of the base."""
        return self.base.extent

    @property
    def across(self) -> int:
        """Index of the direction across the crowned face."""
        return self.surfaces.index(self.surface) // 2

    @property
    def at_high_end(self) -> bool:
        """Whether the face lies at the upper end of the coordinate across it."""
        return self.surfaces.index(self.surface) % 2 == 1

    @property
    def bent(self) -> tuple[int, ...]:
        """Indices of the directions along which the depth of the face is quadratic.

        Along r it is quadratic even if the face is crowned along theta alone.
        """
        if isinstance(self.base, Sector):
            return 0, 1
        return tuple(i for i, name in enumerate(self.directions) if name in self.radii)

    @property
    def fall(self) -> float:
        """Largest depth (m) of the face below its apex."""
        ends = np.meshgrid(*self.extent, indexing="ij")
        corners = np.stack(ends, axis=-1).reshape(-1, len(ends))
        if isinstance(self.base, Sector):
            r, theta = corners[:, 0], np.deg2rad(corners[:, 1])
            corners[:, 0], corners[:, 1] = r * np.cos(theta), r * np.sin(theta)
        return float(self.depth(corners)[0].max())

    def depth(self, points: Floats) -> tuple[Floats, Floats]:
        """Depth of the face below its apex (m), (...), and its gradient, (..., dim).

        ``points`` are Cartesian points of the base (m), (..., dim); their coordinate across the
        face is ignored.
        """
        total, slope = np.zeros(points.shape[:-1]), np.zeros(points.shape)
        for name, radius in self.radii.items():
            axis = self.directions.index(name)
            apex = self.apex.get(name, 0.5 * sum(self.extent[axis]))
            offset = np.zeros(points.shape)  # from the apex, of length s
            if not isinstance(self.base, Sector):
                offset[..., axis] = points[..., axis] - apex
            else:
                plane = points[..., :2]
                r = np.hypot(plane[..., 0], plane[..., 1])[..., None]
                if name == "r":
                    offset[..., :2] = (r - apex) * plane / r
                else:  # the point of equal radius at the apex moves with r
                    middle = np.array([np.cos(np.deg2rad(apex)), np.sin(np.deg2rad(apex))])
                    offset[..., :2] = plane - r * middle
                    slope[..., :2] -= (offset[..., :2] @ middle)[..., None] / r * plane / radius
            total += (offset**2).sum(axis=-1) / (2 * radius)
            slope += offset / radius
        return total, slope

    def height(self, points: Floats) -> tuple[Floats, Floats]:
        """Height of Cartesian points above the crowned face (m), (...), and its gradient."""
        outwards, (depth, gradient) = (1.0 if self.at_high_end else -1.0), self.depth(points)
        gradient[..., self.across] += outwards
        above = points[..., self.across] - self.extent[self.across][self.at_high_end]
        return outwards * above + depth, gradient

    def crown(self, points: Floats) -> Floats:
        """Map points of the base (m), shape (..., dim), to the crowned shape.

        Points of the face move by its depth, opposite ones not at all, those between in proportion.
        """
        low, high = self.extent[self.across]
        share = (points[..., self.across] - low) / (high - low)
        inwards = -share if self.at_high_end else 1.0 - share
        moved = points.copy()
        moved[..., self.across] += inwards * self.depth(points)[0]
        return moved


def crowned_bezier(
    shape: Crowned, degrees: Sequence[int], control_points: Floats, weights: Floats
) -> tuple[tuple[int, ...], Floats, Floats]:
    """Degrees, control points and weights of a crowned patch whose base is one Bezier element.

    The crowned coordinate times the weight function is a polynomial of the raised degrees, and is
    interpolated on a grid.
    """
    raised = tuple(max(p, 2) if axis in shape.bent else p for axis, p in enumerate(degrees))
    net = np.concatenate([control_points * weights[..., None], weights[..., None]], axis=-1)
    for axis, (p, q) in enumerate(zip(degrees, raised, strict=True)):
        net = _along(net, axis, _bernstein(p, np.linspace(0, 1, q + 1)))
    weight = net[..., -1:]
    net = np.concatenate([weight * shape.crown(net[..., :-1] / weight), weight], axis=-1)
    for axis, q in enumerate(raised):
        net = _along(net, axis, np.linalg.inv(_bernstein(q, np.linspace(0, 1, q + 1))))
    return raised, net[..., :-1] / net[..., -1:], net[..., -1]


def _bernstein(degree: int, t: Floats) -> Floats:
    """Values of the Bernstein polynomials, shape (len(t), degree + 1)."""
    k = np.arange(degree + 1)
    return comb(degree, k) * t[:, None] ** k * (1 - t[:, None]) ** (degree - k)


def _along(net: Floats, axis: int, matrix: Floats) -> Floats:
    """Combine control points along one axis."""
    return np.moveaxis(np.tensordot(matrix, net, axes=(1, axis)), 0, axis)
