"""NURBS patches of the shapes: coarsest exact geometry, element boundaries, named faces.

Circular arcs are quadratic rational Bezier curves of control points P0, P1, P2 and weights
1, cos(alpha), 1 with alpha half the angle of the arc (Piegl & Tiller, The NURBS Book, sec. 7.3).
With psi the angle from the middle of the arc, their parameter t in [0, 1] obeys

    tan(psi / 2) = (2 t - 1) tan(alpha / 2),

so that an angle becomes a parameter in closed form. A patch over an arc from radius 0 is collapsed
there: its control points along the arc coincide.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError
from meshes.breaks import Breaks, blocks_of, check_breaks
from meshes.crowned import Crowned, crowned_bezier
from meshes.patches import Faces, GivenPatch, NurbsFile, Patches
from meshes.placement import IN_PLACE, Placement
from meshes.shapes import Box, MeshFile, Rectangle, Shape, VentilatedDisc

_LINE = np.array([0.0, 0.0, 1.0, 1.0])
_ARC = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])


@dataclass(frozen=True)
class NurbsPatch:
    """Coarsest exact geometry of a patch, and its element boundaries."""

    degrees: tuple[int, ...]  # along each parameter
    knots: tuple[Floats, ...]  # open knot vector along each parameter
    control_points: Floats  # (m), shape (n1, ..., dim), not multiplied by the weights
    weights: Floats  # shape (n1, ...)
    breaks: tuple[Floats, ...]  # parameters of the element boundaries, both ends included


def nurbs_shape(
    shape: Shape, breaks: Breaks, placement: Placement = IN_PLACE
) -> tuple[list[NurbsPatch], Faces]:
    """NURBS patches of a shape, joined where their faces coincide, and its named faces.

    There is one of each block (:func:`meshes.breaks.blocks_of`).
    """
    check_breaks(shape, breaks)
    patches, faces = _patches(shape, breaks)
    return [replace(p, control_points=placement.apply(p.control_points)) for p in patches], faces


def _patches(shape: Shape, breaks: Breaks) -> tuple[list[NurbsPatch], Faces]:
    """Patches of a shape before its placement, and its faces."""
    match shape:
        case Patches() | NurbsFile():
            pairs = zip(shape.given.patches, shape.given.nets, strict=True)
            return [_given(patch, net, breaks) for patch, net in pairs], shape.given.faces
        case Crowned():
            patches, faces = _patches(shape.base, breaks)
            return [_crowned(shape, patch) for patch in patches], faces
        case MeshFile() | VentilatedDisc():
            raise InputError("shape", shape.shape, "a shape that has NURBS patches")
    blocks, faces = blocks_of(shape, breaks)
    flat = _rectangle if isinstance(shape, Box | Rectangle) else _part_of_ring
    return [_extruded(flat(*block[:2]), block[2:]) for block in blocks], faces


def _linear_parameters(values: Floats) -> Floats:
    parameters = (values - values[0]) / (values[-1] - values[0])
    parameters[-1] = 1.0
    return parameters


def _rectangle(x: Floats, y: Floats) -> NurbsPatch:
    grid = np.meshgrid(x[[0, -1]], y[[0, -1]], indexing="ij")
    parameters = _linear_parameters(x), _linear_parameters(y)
    return NurbsPatch((1, 1), (_LINE, _LINE), np.stack(grid, axis=-1), np.ones((2, 2)), parameters)


def _part_of_ring(radii: Floats, breaks: Floats) -> NurbsPatch:
    """Patch between radii and angles (degrees) less than 180 apart."""
    angles = breaks[[0, -1]]
    start, end = angles
    middle, half = np.deg2rad((start + end) / 2), np.deg2rad((end - start) / 2)
    # Multiples of 90 degrees have exact control points: patches then meet exactly.
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
    """Extrude a plane patch between heights; return it unchanged if there are none."""
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
    """A given patch with its control points, and breaks scaled to the ranges of parameters."""
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
