"""Faces of patches cut where their normal jumps: a smooth map for each piece.

A knot repeated as often as the degree lets the map of a face have a kink. There the net of control
points is that of two faces which share the points on the kink, so that a cut changes no function.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from cea.arrays import Floats
from cea.surface_points import TANGENT
from iga_cea.face import PatchFace
from iga_cea.face_shape import FaceShape
from iga_cea.grids import grid_points
from iga_cea.patch import subdivided


def smooth_pieces(face: PatchFace) -> list[PatchFace]:
    """A face cut at its kinks; the face itself where it has none."""
    pieces = [face]
    for axis in range(face.dim - 1):
        kinks = [t for t in _repeated(face, axis) if _is_kink(face, axis, t)]
        pieces = [part for piece in pieces for part in _cut_at(piece, axis, kinks)]
    return pieces


def _repeated(face: PatchFace, axis: int) -> Floats:
    """Inner knots of the geometry at which its map is no more than continuous."""
    knots, count = np.unique(face.shape.knots[axis][1:-1], return_counts=True)
    inner = (knots > face.knots[axis][0]) & (knots < face.knots[axis][-1])
    return knots[inner & (count >= face.shape.degrees[axis])]


def _is_kink(face: PatchFace, axis: int, knot: float) -> bool:
    """Whether normals on both sides of a knot differ somewhere along it."""
    parameters = [subdivided(breaks, 2) for breaks in face.breaks]
    parameters[axis] = np.array([knot])
    xi = grid_points(tuple(parameters))
    one, other = (piece.normals(xi)[1] for piece in _cut(face, axis, knot))
    return bool(np.einsum("ij,ij->i", one, other).min() < TANGENT)


def _cut_at(face: PatchFace, axis: int, knots: Sequence[float]) -> Iterator[PatchFace]:
    """Pieces of a face between some rising knots."""
    for knot in knots:
        piece, face = _cut(face, axis, knot)
        yield piece
    yield face


def _cut(face: PatchFace, axis: int, knot: float) -> tuple[PatchFace, PatchFace]:
    """Both sides of a knot at which the splines along an axis are no more than continuous."""
    below, above = _knots(face.knots[axis], face.degrees[axis], knot)
    shapes = _cut_shape(face.shape, axis, knot)
    pieces = []
    for knots, start, shape in zip((below, above), (True, False), shapes, strict=True):
        count = len(knots) - face.degrees[axis] - 1
        kept = slice(count) if start else slice(-count, None)
        net = (slice(None),) * axis + (kept,)
        pieces.append(
            replace(
                face,
                knots=(*face.knots[:axis], knots, *face.knots[axis + 1 :]),
                control_points=np.ascontiguousarray(face.control_points[net]),
                weights=np.ascontiguousarray(face.weights[net]),
                dofs=np.ascontiguousarray(face.dofs[net]),
                shape=shape,
            )
        )
    return pieces[0], pieces[1]


def _cut_shape(shape: FaceShape, axis: int, knot: float) -> tuple[FaceShape, FaceShape]:
    """Both sides of the map before knots were inserted."""
    sizes = [len(k) - p - 1 for k, p in zip(shape.knots, shape.degrees, strict=True)]
    net = shape.net.reshape(*sizes, -1)
    below, above = _knots(shape.knots[axis], shape.degrees[axis], knot)
    first, last = (len(knots) - shape.degrees[axis] - 1 for knots in (below, above))
    parts = (net.take(range(first), axis), net.take(range(sizes[axis] - last, sizes[axis]), axis))
    one, other = (
        replace(
            shape,
            knots=(*shape.knots[:axis], knots, *shape.knots[axis + 1 :]),
            net=part.reshape(-1, shape.net.shape[1]),
        )
        for knots, part in zip((below, above), parts, strict=True)
    )
    return one, other


def _knots(knots: Floats, degree: int, knot: float) -> tuple[Floats, Floats]:
    """Open knot vectors on both sides of a knot."""
    end = np.full(degree + 1, knot)
    return np.append(knots[knots < knot], end), np.append(end, knots[knots > knot])
