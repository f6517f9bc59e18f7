"""Division of faces of patches where their normal jumps, into pieces with smooth maps.

At a knot of multiplicity p the map of a face may have a kink. There the control net is that of two
faces that share the points on the kink, so that the division changes no function.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from cea.arrays import Floats
from cea.surface_points import TANGENT
from iga_cea.face import PatchFace
from iga_cea.face_shape import FaceShape
from iga_cea.patch import subdivided
from iga_cea.splines import grid_points


def smooth_pieces(face: PatchFace) -> list[PatchFace]:
    """Return the pieces of a face between its kinks."""
    pieces = [face]
    for axis in range(face.dim - 1):
        kinks = [t for t in _repeated(face, axis) if _is_kink(face, axis, t)]
        pieces = [part for piece in pieces for part in _cut_at(piece, axis, kinks)]
    return pieces


def _repeated(face: PatchFace, axis: int) -> Floats:
    """Return the inner knots of the geometry at which the map is only continuous."""
    knots, count = np.unique(face.shape.knots[axis][1:-1], return_counts=True)
    inner = (knots > face.knots[axis][0]) & (knots < face.knots[axis][-1])
    return knots[inner & (count >= face.shape.degrees[axis])]


def _is_kink(face: PatchFace, axis: int, knot: float) -> bool:
    """Return whether the normal jumps at a knot, anywhere along it."""
    parameters = [subdivided(breaks, 2) for breaks in face.breaks]
    parameters[axis] = np.array([knot])
    xi = grid_points(tuple(parameters))
    one, other = (piece.normals(xi)[1] for piece in _cut(face, axis, knot))
    return bool(np.einsum("ij,ij->i", one, other).min() < TANGENT)


def _cut_at(face: PatchFace, axis: int, knots: Sequence[float]) -> Iterator[PatchFace]:
    """Yield the pieces of a face between increasing knots."""
    for knot in knots:
        piece, face = _cut(face, axis, knot)
        yield piece
    yield face


def _cut(face: PatchFace, axis: int, knot: float) -> tuple[PatchFace, PatchFace]:
    """Return both parts of a face, divided at a knot of multiplicity p along an axis."""
    shape = face.shape
    sizes = [len(knots) - p - 1 for knots, p in zip(shape.knots, shape.degrees, strict=True)]
    net = shape.net.reshape(*sizes, -1)
    pieces = []
    for (knots, own), (plain, of_shape) in zip(
        _sides(face, axis, knot), _sides(shape, axis, knot), strict=True
    ):
        pieces.append(
            replace(
                face,
                knots=knots,
                control_points=np.ascontiguousarray(face.control_points[own]),
                weights=np.ascontiguousarray(face.weights[own]),
                dofs=np.ascontiguousarray(face.dofs[own]),
                shape=replace(shape, knots=plain, net=net[of_shape].reshape(-1, net.shape[-1])),
            )
        )
    return pieces[0], pieces[1]


def _sides(
    of: PatchFace | FaceShape, axis: int, knot: float
) -> Iterator[tuple[tuple[Floats, ...], tuple[slice, ...]]]:
    """Yield the knots of the parts below and above a knot, and their slices of the net."""
    knots, degree = of.knots[axis], of.degrees[axis]
    end = np.full(degree + 1, knot)
    below, above = np.append(knots[knots < knot], end), np.append(end, knots[knots > knot])
    first, last = (len(side) - degree - 1 for side in (below, above))
    for side, part in ((below, slice(first)), (above, slice(-last, None))):
        yield (*of.knots[:axis], side, *of.knots[axis + 1 :]), (slice(None),) * axis + (part,)
