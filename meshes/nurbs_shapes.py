"""NURBS patches of the shapes: coarsest exact geometry, wanted element boundaries, named faces.

Circular arcs are quadratic rational Bezier curves of control points P0, P1, P2 and weights
1, cos(alpha), 1 with alpha half the angle of the arc (Piegl & Tiller, The NURBS Book, sec. 7.3).
With psi the angle from the middle of the arc, their parameter t in [0, 1] obeys

    tan(psi / 2) = (2 t - 1) tan(alpha / 2),

so that an angle becomes a parameter in closed form. A patch over an arc from radius 0 is collapsed
there: its control points along the arc coincide.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError, require
from meshes.breaks import Breaks, check_ends
from meshes.crowned import Crowned, crowned_bezier
from meshes.patches import Face, GivenPatch, NurbsFile, Patches
from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Disc, Hub, Rectangle, Ring, RingSector, Sector, Shape

Faces = Mapping[str, tuple[Face, ...]]

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
        Open knot vector along each parameter.
    control_points
        Control points (m), shape (n1, ..., dim), not multiplied by the weights.
    weights
        Weights, shape (n1, ...).
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
    faces: Faces


def nurbs_shape(
    shape: Shape, breaks: Breaks, placement: Placement = _PLACED_AT_ORIGIN
) -> NurbsShape:
    """NURBS patches of a shape: one of straight shapes and sectors, four quarters of closed ones.

    A hub has four quarters for each of its layers.
    """
    _check(shape, breaks)
    match shape:
        case Patches():
            patches = tuple(
                _given(patch, net, breaks, placement)
                for patch, net in zip(shape.patches, shape.nets, strict=True)
            )
            return NurbsShape(patches, MappingProxyType(shape.faces))
        case NurbsFile():
            return nurbs_shape(shape.given, breaks, placement)
        case Box() | Rectangle():
            faces = _sides(shape.surfaces, range(len(breaks)))
            return NurbsShape((_straight(shape, breaks, placement),), faces)
        case Sector() | RingSector():
            arc = _Arc.between(shape.start, shape.end, breaks[1])
            faces = _sides(shape.surfaces, range(len(breaks)))
            return NurbsShape((_round(arc, breaks[0], breaks[2:], placement),), faces)
        case Annulus() | Ring():
            quarters = _quarters(breaks[1], breaks[0], breaks[2:], placement)
            return NurbsShape(quarters, _sides(shape.surfaces, range(0, len(breaks), 2), 4))
        case Disc():
            quarters = _quarters(breaks[1], breaks[0], breaks[2:], placement)
            named = {"outer": (0, 1), "bottom": (2, 0), "top": (2, 1)}
            faces = {name: _on_all(range(4), *end) for name, end in named.items()}
            return NurbsShape(quarters, MappingProxyType(faces))
        case Crowned():
            flat = nurbs_shape(shape.base, breaks)
            patches = tuple(_crowned(shape, patch, placement) for patch in flat.patches)
            return NurbsShape(patches, flat.faces)
        case Hub():
            return _hub(shape, breaks, placement)
        case _:
            raise InputError("shape", shape.shape, "a shape that has NURBS patches")


def _check(shape: Shape, breaks: Breaks) -> None:
    check_ends(shape, breaks)
    joints: dict[int, Sequence[float]] = {}
    if isinstance(shape, Annulus | Disc | Hub | Ring):
        joints[1] = (90.0, 180.0, 270.0)
    if isinstance(shape, Hub):
        joints |= {0: (shape.hub_radius,), 2: (shape.bottom, shape.top)}
    for axis, needed in joints.items():
        distance = np.abs(breaks[axis][:, None] - needed).min(axis=0)
        field, allowed = f"breaks of {shape.directions[axis]}", f"{needed} among them"
        require(bool(np.all(distance <= _SNAP)), field, breaks[axis], allowed)


def _sides(names: Sequence[str], axes: Sequence[int], patches: int = 1) -> Faces:
    """Name both sides of each axis, in order, on every patch."""
    ends = [(axis, side) for axis in axes for side in (0, 1)]
    return MappingProxyType(
        {name: _on_all(range(patches), *end) for name, end in zip(names, ends, strict=True)}
    )


def _on_all(patches: Sequence[int], axis: int, side: int) -> tuple[Face, ...]:
    return tuple((patch, axis, side) for patch in patches)


def _between(values: Floats, low: float, high: float) -> Floats:
    return values[(values > low - _SNAP) & (values < high + _SNAP)]


def _linear_parameters(values: Floats) -> Floats:
    parameters = (values - values[0]) / (values[-1] - values[0])
    parameters[-1] = 1.0
    return parameters


@dataclass(frozen=True)
class _Arc:
    """Arc of the unit circle."""

    points: Floats
    weight: float
    parameters: Floats

    @classmethod
    def between(cls, start: float, end: float, breaks: Floats) -> "_Arc":
        """Arc between two angles less than 180 apart, its breaks at given angles (degrees)."""
        middle, half = np.deg2rad((start + end) / 2), np.deg2rad((end - start) / 2)
        # Multiples of 90 degrees have exact control points: patches then meet exactly.
        angles = np.array([start, end])
        ends = np.stack([_cosine(angles), _cosine(angles - 90.0)], axis=1)
        corner = ends.sum(axis=0) / (2 * np.cos(half) ** 2)
        from_middle = np.deg2rad(breaks) - middle
        parameters = (1 + np.tan(from_middle / 2) / np.tan(half / 2)) / 2
        parameters[[0, -1]] = 0.0, 1.0
        return cls(np.array([ends[0], corner, ends[1]]), float(np.cos(half)), parameters)


def _cosine(degrees: Floats) -> Floats:
    return np.where(degrees % 180.0 == 90.0, 0.0, np.cos(np.deg2rad(degrees)))


def _given(patch: GivenPatch, net: Floats, breaks: Breaks, placement: Placement) -> NurbsPatch:
    """A given patch with its net, breaks scaled to the ranges of its parameters."""
    knots = tuple(np.asarray(k, dtype=float) for k in patch.knots)
    return NurbsPatch(
        degrees=tuple(patch.degrees),
        knots=knots,
        control_points=placement.apply(net),
        weights=patch.point_weights,
        breaks=tuple(
            np.clip(k[0] + values * (k[-1] - k[0]), k[0], k[-1])
            for k, values in zip(knots, breaks, strict=True)
        ),
    )


def _straight(shape: Box | Rectangle, breaks: Breaks, placement: Placement) -> NurbsPatch:
    grid = np.meshgrid(*shape.extent, indexing="ij")
    dim = len(breaks)
    return NurbsPatch(
        degrees=(1,) * dim,
        knots=(_LINE,) * dim,
        control_points=placement.apply(np.stack(grid, axis=-1)),
        weights=np.ones((2,) * dim),
        breaks=tuple(_linear_parameters(values) for values in breaks),
    )


def _round(
    arc: _Arc, radii: Floats, heights: tuple[Floats, ...], placement: Placement
) -> NurbsPatch:
    """Patch over an arc between radii, in plane strain or between heights."""
    plane = radii[[0, -1], None, None] * arc.points
    weights = np.broadcast_to([1.0, arc.weight, 1.0], (2, 3))
    for z in heights:
        ends = np.broadcast_to(z[[0, -1], None], (2, 3, 2, 1))
        plane = np.concatenate([np.stack([plane, plane], axis=2), ends], axis=3)
        weights = np.stack([weights, weights], axis=2)
    extruded = len(heights)
    return NurbsPatch(
        degrees=(1, 2) + (1,) * extruded,
        knots=(_LINE, _ARC) + (_LINE,) * extruded,
        control_points=placement.apply(plane),
        weights=np.array(weights),
        breaks=(_linear_parameters(radii), arc.parameters, *map(_linear_parameters, heights)),
    )


def _crowned(shape: Crowned, patch: NurbsPatch, placement: Placement) -> NurbsPatch:
    """A patch of the base, crowned."""
    degrees, points, weights = crowned_bezier(
        shape, patch.degrees, patch.control_points, patch.weights
    )
    knots = tuple(np.repeat([0.0, 1.0], p + 1) for p in degrees)
    return NurbsPatch(degrees, knots, placement.apply(points), weights, patch.breaks)


def _quarters(
    angles: Floats, radii: Floats, heights: tuple[Floats, ...], placement: Placement
) -> tuple[NurbsPatch, ...]:
    """Four joined patches all the way round."""
    return tuple(
        _round(
            _Arc.between(start, start + 90.0, _between(angles, start, start + 90.0)),
            radii,
            heights,
            placement,
        )
        for start in (0.0, 90.0, 180.0, 270.0)
    )


def _hub(shape: Hub, breaks: Breaks, placement: Placement) -> NurbsShape:
    """Four quarters of the ring, then of each layer of the hub from below."""
    r, theta, z = breaks
    inside, outside = _between(r, 0.0, shape.hub_radius), _between(r, shape.hub_radius, np.inf)
    levels = np.unique([shape.hub_bottom, shape.bottom, shape.top, shape.hub_top])
    patches = list(_quarters(theta, outside, (_between(z, shape.bottom, shape.top),), placement))
    ring = range(4)
    standing_out: list[int] = []
    for low, high in pairwise(levels):
        if low != shape.bottom:
            standing_out += range(len(patches), len(patches) + 4)
        patches += _quarters(theta, inside, (_between(z, low, high),), placement)
    hub = range(4, len(patches))
    return NurbsShape(
        tuple(patches),
        MappingProxyType(
            {
                "bore": _on_all(hub, 0, 0),
                "outer": _on_all(ring, 0, 1),
                "bottom": _on_all(ring, 2, 0),
                "top": _on_all(ring, 2, 1),
                "hub_bottom": _on_all(hub[:4], 2, 0),
                "hub_top": _on_all(hub[-4:], 2, 1),
                "hub_side": _on_all(standing_out, 0, 1),
            }
        ),
    )
