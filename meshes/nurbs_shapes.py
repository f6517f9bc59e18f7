"""NURBS patches of the shapes: coarsest exact geometry, wanted element boundaries, named faces.

Circular arcs are quadratic rational Bezier curves of control points P0, P1, P2 and weights
1, cos(alpha), 1 with alpha half the angle of the arc (Piegl & Tiller, The NURBS Book, sec. 7.3).
With psi the angle from the middle of the arc, their parameter t in [0, 1] obeys

    tan(psi / 2) = (2 t - 1) tan(alpha / 2),

so that an angle becomes a parameter in closed form.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from meshes.breaks import Breaks
from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Sector, Shape

Floats = NDArray[np.float64]
Face = tuple[int, int, int]

_LINE = np.array([0.0, 0.0, 1.0, 1.0])
_ARC = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
_SNAP = 1e-9
_PLACED_AT_ORIGIN = Placement()


@dataclass(frozen=True)
class NurbsPatch:
    """Coarsest exact geometry of a patch and where its element boundaries shall lie.

    Parameters
    ----------
    degrees
        Degree along each parameter.
    knots
        Open knot vector along each parameter, range 0 to 1.
    control_points
        Control points (m), shape (n1, n2, n3, dim), not multiplied by the weights.
    weights
        Weights, shape (n1, n2, n3).
    breaks
        Parameters of the wanted element boundaries along each direction, both ends included.
    """

    degrees: tuple[int, ...]
    knots: tuple[Floats, ...]
    control_points: Floats
    weights: Floats
    breaks: tuple[Floats, ...]


@dataclass(frozen=True)
class NurbsShape:
    """Patches of a shape and its named surfaces.

    Parameters
    ----------
    patches
        The patches, joined where their faces coincide.
    faces
        Faces (patch, axis, side) of each named surface; side 0 is where the parameter is least.
    """

    patches: tuple[NurbsPatch, ...]
    faces: Mapping[str, tuple[Face, ...]]


def nurbs_shape(
    shape: Shape, breaks: Breaks, placement: Placement = _PLACED_AT_ORIGIN
) -> NurbsShape:
    """NURBS patches of a shape: one of a box or sector, four joined quarters of an annulus.

    Parameters
    ----------
    shape
        The shape.
    breaks
        Coordinates of the element boundaries along its three directions (m, degrees), as
        :func:`meshes.shapes.breaks_of` returns them.
    placement
        Where to put it.

    Raises
    ------
    ValueError
        When breaks do not rise from one end of the shape to the other, or those of an annulus
        leave out a joint of its patches.
    """
    _check(shape, breaks)
    if isinstance(shape, Box):
        return NurbsShape((_box(shape, breaks, placement),), _sides(shape.surfaces, range(3)))
    if isinstance(shape, Sector):
        low, high = np.deg2rad(shape.start), np.deg2rad(shape.end)
        middle, half = (low + high) / 2, (high - low) / 2
        angles = np.array([low, middle, high])
        arc = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        arc[1] /= np.cos(half)
        sector = _ring_patch(shape, arc, half, breaks[1] - shape.start, breaks, placement)
        return NurbsShape((sector,), _sides(shape.surfaces, range(3)))
    corners = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    quarter_turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    quarters = []
    for k in range(4):
        inside = (breaks[1] > 90.0 * k - _SNAP) & (breaks[1] < 90.0 * (k + 1) + _SNAP)
        arc = corners @ np.linalg.matrix_power(quarter_turn, k)
        angles = breaks[1][inside] - 90.0 * k
        quarters.append(_ring_patch(shape, arc, np.pi / 4, angles, breaks, placement))
    return NurbsShape(tuple(quarters), _sides(shape.surfaces, (0, 2), patches=4))


def _check(shape: Shape, breaks: Breaks) -> None:
    for name, (low, high), values in zip(shape.directions, shape.extent, breaks, strict=True):
        rises = len(values) >= 2 and bool(np.all(np.diff(values) > 0))
        if not rises or not np.allclose([values[0], values[-1]], [low, high]):
            raise ValueError(f"breaks along {name} = {values}: rising from {low} to {high}")
    if isinstance(shape, Annulus):
        distance = np.abs(breaks[1][:, None] - [90.0, 180.0, 270.0]).min(axis=0)
        if np.any(distance > _SNAP):
            raise ValueError(f"breaks along theta = {breaks[1]}: 90, 180 and 270 among them")


def _sides(names: tuple[str, ...], axes: Iterable[int], patches: int = 1) -> Mapping:
    """Name both sides of each axis, in order, on every patch."""
    ends = [(axis, side) for axis in axes for side in (0, 1)]
    return MappingProxyType(
        {
            name: tuple((patch, *end) for patch in range(patches))
            for name, end in zip(names, ends, strict=True)
        }
    )


def _linear_parameters(values: Floats) -> Floats:
    parameters = (values - values[0]) / (values[-1] - values[0])
    parameters[-1] = 1.0
    return parameters


def _arc_parameters(angles: Floats, half: float) -> Floats:
    """Parameters of angles from the start of an arc (degrees), ``half`` its half angle (rad)."""
    from_middle = np.deg2rad(angles) - half
    parameters = (1 + np.tan(from_middle / 2) / np.tan(half / 2)) / 2
    parameters[[0, -1]] = 0.0, 1.0
    return parameters


def _box(shape: Box, breaks: Breaks, placement: Placement) -> NurbsPatch:
    grid = np.meshgrid(*shape.extent, indexing="ij")
    return NurbsPatch(
        degrees=(1, 1, 1),
        knots=(_LINE,) * 3,
        control_points=placement.apply(np.stack(grid, axis=-1)),
        weights=np.ones((2, 2, 2)),
        breaks=tuple(_linear_parameters(values) for values in breaks),
    )


def _ring_patch(
    shape: Annulus | Sector,
    arc: Floats,
    half: float,
    angles: Floats,
    breaks: Breaks,
    placement: Placement,
) -> NurbsPatch:
    """Patch over one arc given by its control points on the unit circle, shape (3, 2)."""
    control_points = np.empty((2, 3, 2, 3))
    radii = np.array([shape.inner_radius, shape.outer_radius])
    control_points[..., :2] = radii[:, None, None, None] * arc[None, :, None, :]
    control_points[..., 2] = shape.bottom, shape.top
    weights = np.ones((2, 3, 2))
    weights[:, 1] = np.cos(half)
    return NurbsPatch(
        degrees=(1, 2, 1),
        knots=(_LINE, _ARC, _LINE),
        control_points=placement.apply(control_points),
        weights=weights,
        breaks=(
            _linear_parameters(breaks[0]),
            _arc_parameters(angles, half),
            _linear_parameters(breaks[2]),
        ),
    )
