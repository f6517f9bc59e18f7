"""NURBS patches of the shapes: coarsest exact geometry, wanted element boundaries, named faces.

Circular arcs are quadratic rational Bezier curves of control points P0, P1, P2 and weights
1, cos(alpha), 1 with alpha half the angle of the arc (Piegl & Tiller, The NURBS Book, sec. 7.3).
With psi the angle from the middle of the arc, their parameter t in [0, 1] obeys

    tan(psi / 2) = (2 t - 1) tan(alpha / 2),

so that an angle becomes a parameter in closed form. A patch over an arc from radius 0 is collapsed
there: its control points along the arc coincide.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError, require
from meshes.breaks import CLOSED, Breaks, check_ends
from meshes.crowned import Crowned, crowned_bezier
from meshes.patches import Face, GivenPatch, NurbsFile, Patches
from meshes.placement import IN_PLACE, Placement
from meshes.shapes import Annulus, Box, Disc, Hub, Rectangle, Ring, RingSector, Sector, Shape

Faces = dict[str, tuple[Face, ...]]

_LINE = np.array([0.0, 0.0, 1.0, 1.0])
_ARC = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
_SNAP = 1e-9


@dataclass(frozen=True)
class NurbsPatch:
    """Coarsest exact geometry of a patch and where its element boundaries shall lie."""

    degrees: tuple[int, ...]  # along each parameter
    knots: tuple[Floats, ...]  # open knot vector along each parameter
    control_points: Floats  # (m), shape (n1, ..., dim), not multiplied by the weights
    weights: Floats  # shape (n1, ...)
    breaks: tuple[Floats, ...]  # parameters of the wanted element boundaries, both ends included


@dataclass(frozen=True)
class NurbsShape:
    """Patches of a shape, joined where their faces coincide, and its named surfaces.

    Faces are (patch, axis, side); side 0 is where the parameter is least.
    """

    patches: tuple[NurbsPatch, ...]
    faces: Faces


def nurbs_shape(shape: Shape, breaks: Breaks, placement: Placement = IN_PLACE) -> NurbsShape:
    """NURBS patches of a shape: one of straight shapes and sectors, four quarters of closed ones.

    A hub has four quarters for each of its layers.
    """
    _check(shape, breaks)
    patches, faces = _patches(shape, breaks)
    placed = (replace(p, control_points=placement.apply(p.control_points)) for p in patches)
    return NurbsShape(tuple(placed), faces)


def _patches(shape: Shape, breaks: Breaks) -> tuple[list[NurbsPatch], Faces]:
    """Patches of a shape where it stands by itself, and its faces."""
    heights = breaks[2:]
    match shape:
        case Patches() | NurbsFile():
            pairs = zip(shape.given.patches, shape.given.nets, strict=True)
            return [_given(patch, net, breaks) for patch, net in pairs], shape.given.faces
        case Box() | Rectangle():
            patches = [_extruded(_rectangle(breaks), heights)]
            return patches, _on_all([0], _ends(shape.surfaces, range(len(breaks))))
        case Sector() | RingSector():
            part = _part_of_ring(breaks[0], shape.start, shape.end, breaks[1])
            patches = [_extruded(part, heights)]
            return patches, _on_all([0], _ends(shape.surfaces, range(len(breaks))))
        case Annulus() | Ring():
            ends = _ends(shape.surfaces, range(0, len(breaks), 2))
            return _quarters(*breaks), _on_all(range(4), ends)
        case Disc():
            named = {"outer": (0, 1), "bottom": (2, 0), "top": (2, 1)}
            return _quarters(*breaks), _on_all(range(4), named)
        case Crowned():
            patches, faces = _patches(shape.base, breaks)
            return [_crowned(shape, patch) for patch in patches], faces
        case Hub():
            return _hub(shape, breaks)
        case _:
            raise InputError("shape", shape.shape, "a shape that has NURBS patches")


def _check(shape: Shape, breaks: Breaks) -> None:
    check_ends(shape, breaks)
    joints: dict[int, Sequence[float]] = {}
    if isinstance(shape, CLOSED):
        joints[1] = (90.0, 180.0, 270.0)
    if isinstance(shape, Hub):
        joints |= {0: (shape.hub_radius,), 2: (shape.bottom, shape.top)}
    for axis, needed in joints.items():
        distance = np.abs(breaks[axis][:, None] - needed).min(axis=0)
        field, allowed = f"breaks of {shape.directions[axis]}", f"{needed} among them"
        require(bool(np.all(distance <= _SNAP)), field, breaks[axis], allowed)


def _ends(names: Sequence[str], axes: Sequence[int]) -> dict[str, tuple[int, int]]:
    """Axis and side by name: both sides of each axis in order."""
    return dict(zip(names, ((axis, side) for axis in axes for side in (0, 1)), strict=True))


def _on_all(patches: Sequence[int], ends: Mapping[str, tuple[int, int]]) -> Faces:
    """The same faces of several patches by name."""
    return {name: tuple((patch, *end) for patch in patches) for name, end in ends.items()}


def _between(values: Floats, low: float, high: float) -> Floats:
    return values[(values > low - _SNAP) & (values < high + _SNAP)]


def _linear_parameters(values: Floats) -> Floats:
    parameters = (values - values[0]) / (values[-1] - values[0])
    parameters[-1] = 1.0
    return parameters


def _rectangle(breaks: Breaks) -> NurbsPatch:
    grid = np.meshgrid(*(line[[0, -1]] for line in breaks[:2]), indexing="ij")
    parameters = tuple(_linear_parameters(line) for line in breaks[:2])
    return NurbsPatch((1, 1), (_LINE, _LINE), np.stack(grid, axis=-1), np.ones((2, 2)), parameters)


def _part_of_ring(radii: Floats, start: float, end: float, breaks: Floats) -> NurbsPatch:
    """Patch between radii and angles less than 180 apart, its breaks at given angles (degrees)."""
    middle, half = np.deg2rad((start + end) / 2), np.deg2rad((end - start) / 2)
    # Multiples of 90 degrees have exact control points: patches then meet exactly.
    angles = np.array([start, end])
    ends = np.stack([_cosine(angles), _cosine(angles - 90.0)], axis=1)
    corner = ends.sum(axis=0) / (2 * np.cos(half) ** 2)
    arc = np.array([ends[0], corner, ends[1]])
    parameters = (1 + np.tan((np.deg2rad(breaks) - middle) / 2) / np.tan(half / 2)) / 2
    parameters[[0, -1]] = 0.0, 1.0
    return NurbsPatch(
        degrees=(1, 2),
        knots=(_LINE, _ARC),
        control_points=radii[[0, -1], None, None] * arc,
        weights=np.tile([1.0, np.cos(half), 1.0], (2, 1)),
        breaks=(_linear_parameters(radii), parameters),
    )


def _cosine(degrees: Floats) -> Floats:
    return np.where(degrees % 180.0 == 90.0, 0.0, np.cos(np.deg2rad(degrees)))


def _extruded(patch: NurbsPatch, heights: Sequence[Floats]) -> NurbsPatch:
    """A patch of the plane between heights, or as it is where there are none."""
    for z in heights:
        layers = [np.insert(patch.control_points, 2, end, axis=-1) for end in z[[0, -1]]]
        patch = NurbsPatch(
            degrees=(*patch.degrees, 1),
            knots=(*patch.knots, _LINE),
            control_points=np.stack(layers, axis=2),
            weights=np.stack([patch.weights, patch.weights], axis=2),
            breaks=(*patch.breaks, _linear_parameters(z)),
        )
    return patch


def _given(patch: GivenPatch, net: Floats, breaks: Breaks) -> NurbsPatch:
    """A given patch with its net, breaks scaled to the ranges of its parameters."""
    knots = tuple(np.asarray(k, dtype=float) for k in patch.knots)
    scaled = tuple(
        np.clip(k[0] + values * (k[-1] - k[0]), k[0], k[-1])
        for k, values in zip(knots, breaks, strict=True)
    )
    return NurbsPatch(tuple(patch.degrees), knots, net, patch.point_weights, scaled)


def _crowned(shape: Crowned, patch: NurbsPatch) -> NurbsPatch:
    """A patch of the base, crowned."""
    degrees, points, weights = crowned_bezier(
        shape, patch.degrees, patch.control_points, patch.weights
    )
    knots = tuple(np.repeat([0.0, 1.0], p + 1) for p in degrees)
    return NurbsPatch(degrees, knots, points, weights, patch.breaks)


def _quarters(radii: Floats, angles: Floats, *heights: Floats) -> list[NurbsPatch]:
    """Four joined patches all the way round."""
    starts = (0.0, 90.0, 180.0, 270.0)
    spans = ((start, start + 90.0) for start in starts)
    return [
        _extruded(_part_of_ring(radii, *span, _between(angles, *span)), heights) for span in spans
    ]


def _hub(shape: Hub, breaks: Breaks) -> tuple[list[NurbsPatch], Faces]:
    """Four quarters of the ring, then of each layer of the hub from below."""
    r, theta, z = breaks
    inside, outside = _between(r, 0.0, shape.hub_radius), _between(r, shape.hub_radius, np.inf)
    levels = np.unique([shape.hub_bottom, shape.bottom, shape.top, shape.hub_top])
    patches = _quarters(outside, theta, _between(z, shape.bottom, shape.top))
    standing_out: list[int] = []
    for low, high in pairwise(levels):
        if low != shape.bottom:
            standing_out += range(len(patches), len(patches) + 4)
        patches += _quarters(inside, theta, _between(z, low, high))
    hub = range(4, len(patches))
    faces = _on_all(range(4), {"outer": (0, 1), "bottom": (2, 0), "top": (2, 1)})
    faces |= _on_all(hub, {"bore": (0, 0)}) | _on_all(hub[:4], {"hub_bottom": (2, 0)})
    faces |= _on_all(hub[-4:], {"hub_top": (2, 1)}) | _on_all(standing_out, {"hub_side": (0, 1)})
    return patches, {name: faces[name] for name in shape.surfaces}
