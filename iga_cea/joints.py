"""Detection of joined faces of patches from geometry, and of patches that touch otherwise."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, permutations, product
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from cea.arrays import Floats, Ints, connected
from cea.errors import InputError
from iga_cea.face import PatchFace
from iga_cea.patch import subdivided
from iga_cea.splines import grid_points
from iga_cea.surface import NurbsSurface

TOLERANCE = 1e-7
"""Distance, relative to the local mesh size, below which points coincide."""

_NEAR = 1e-3
"""Gap, relative to the elements behind, up to which equal faces should have been joined."""

_SAME_PARAMETER = 1e-9
"""Relative difference below which knots, or ratios of weights, are equal."""


def joined_dofs(faces: Sequence[PatchFace], field: str) -> Ints:
    """Return pairs of dofs that joined faces share, shape (n, 2).

    Two faces, of one closed patch or of two patches, are joined if their control points coincide,
    their knots are equal and their weights are proportional, up to rotations and reflections of the
    parameters of one face.
    """
    near = list(_neighbours([_Side(face) for face in faces]))
    joints = [joint for a, b in near if (joint := _joined(a, b, field)) is not None]
    inner = {id(face) for joint in joints for face in (joint.a, joint.b)}
    for a, b in near:  # points on a joint are also covered by the free faces of its patches
        free = id(a.face) not in inner and id(b.face) not in inner
        if free and (_touch(a, b) or _touch(b, a)):
            allowed = "joined faces with equal nets of control points, or faces apart"
            raise InputError(field, f"{_name(a.face)} and {_name(b.face)}", allowed)
    _check_pieces(faces, joints, field)
    pairs = [np.stack([j.a.dofs[..., 0].ravel(), j.order.ravel()], axis=1) for j in joints]
    return np.concatenate([np.empty((0, 2), dtype=np.int64), *pairs])


def _joined(side_a: "_Side", side_b: "_Side", field: str) -> "_Joint | None":
    """Return the joint of two faces; None if they differ or are apart."""
    a, b, depth = side_a.face, side_b.face, min(side_a.depth, side_b.depth)
    joint, names = _joint(a, b), f"{_name(a)} and {_name(b)}"
    if joint is None or joint.gap > _NEAR * depth:
        return None
    if joint.gap > TOLERANCE * depth:
        allowed = f"joined faces; these are {joint.gap:.3g} m apart: merge_nodes joins them"
        raise InputError(field, names, allowed)
    if not _face_each_other(a, b):
        allowed = "adjacent patches, none given twice: these overlap"
        raise InputError(field, names, allowed)
    return joint


def _face_each_other(a: PatchFace, b: PatchFace) -> bool:
    """Return whether the outward normals of joined faces are opposite at their centres."""
    middles = [np.array([[(k[0] + k[-1]) / 2 for k in face.knots]]) for face in (a, b)]
    one, other = (face.normals(xi)[1][0] for face, xi in zip((a, b), middles, strict=True))
    return bool(one @ other < 0)


def _check_pieces(faces: Sequence[PatchFace], joints: Sequence["_Joint"], field: str) -> None:
    """Raise InputError, with their distance, if patches form several bodies."""
    patches, of_face = np.unique([face.patch for face in faces], return_inverse=True)
    ends = np.searchsorted(patches, [(j.a.patch, j.b.patch) for j in joints]).reshape(-1, 2)
    piece = connected(ends, len(patches))
    count = piece.max() + 1
    if count == 1:
        return
    nets = [face.control_points[..., 0, :].reshape(-1, face.dim) for face in faces]
    first, others = (
        np.concatenate(
            [net for net, n in zip(nets, of_face, strict=True) if (piece[n] == 0) == own]
        )
        for own in (True, False)
    )
    gap = KDTree(first).query(others)[0].min()
    allowed = (
        f"one body of patches joined by whole faces: the nearest control points are {gap:.3g} m "
        "apart; merge_nodes joins closer ones"
    )
    raise InputError(field, f"{count} bodies that share no face", allowed)


def _name(face: PatchFace) -> str:
    return f"patch {face.patch} axis {face.axis} side {face.side}"


@dataclass(frozen=True)
class _Side:
    """Face with cached data for neighbour tests."""

    face: PatchFace

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        """Bounding box of its control points, which contains the face."""
        outer = self.face.control_points[..., 0, :].reshape(-1, self.face.dim)
        return outer.min(axis=0), outer.max(axis=0)

    @cached_property
    def depth(self) -> float:
        """Smallest size of the elements behind it (m), from control points."""
        net = self.face.control_points
        steps = [np.linalg.norm(np.diff(net, axis=k), axis=-1) for k in range(self.face.dim)]
        return float(min(step.max() for step in steps))

    @cached_property
    def samples(self) -> tuple[Floats, Floats, np.ndarray]:
        """Ends and middles of all spans: positions, normals, and whether on the edge."""
        face = self.face
        xi = grid_points(tuple(subdivided(breaks, 2) for breaks in face.breaks))
        x, normal, _ = face.normals(xi)
        ends = np.array([knots[[0, -1]] for knots in face.knots])
        return x, normal, ((xi == ends[:, 0]) | (xi == ends[:, 1])).any(axis=1)

    @cached_property
    def edge(self) -> KDTree:
        """Search tree of the samples on the edge."""
        x, _, on_edge = self.samples
        return KDTree(x[on_edge])

    @cached_property
    def chart(self) -> NurbsSurface:
        """The face as a surface, for point location."""
        return NurbsSurface("side", [self.face], 0)


def _neighbours(sides: Sequence[_Side]) -> Iterator[tuple[_Side, _Side]]:
    """Yield pairs of faces whose bounding boxes touch."""
    low, high = (np.array(ends) for ends in zip(*(side.box for side in sides), strict=True))
    margin = np.array([max(TOLERANCE * side.face.size, _NEAR * side.depth) for side in sides])
    for i, j in combinations(range(len(sides)), 2):
        near = np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])
        if np.all(near >= -min(margin[i], margin[j])):
            yield sides[i], sides[j]


class _Joint(NamedTuple):
    """Two equal faces: dofs of b in the order of a, and the largest distance (m) of their nets."""

    a: PatchFace
    b: PatchFace
    order: Ints
    gap: float


def _joint(a: PatchFace, b: PatchFace) -> _Joint | None:
    """Return the joint of equal faces with the smallest gap of all orientations, or None."""
    axes, found = range(a.dim - 1), list[_Joint]()
    for order in permutations(axes):
        for flips in product((False, True), repeat=len(order)):
            if not all(_same_knots(a, k, b, order[k], flips[k]) for k in axes):
                continue
            view = tuple(slice(None, None, -1 if flip else 1) for flip in flips)
            points = b.control_points[..., 0, :].transpose(*order, a.dim - 1)[view]
            ratio = b.weights[..., 0].transpose(order)[view] / a.weights[..., 0]
            if np.ptp(ratio) <= _SAME_PARAMETER * ratio.max():
                gap = float(np.linalg.norm(points - a.control_points[..., 0, :], axis=-1).max())
                found.append(_Joint(a, b, b.dofs[..., 0].transpose(order)[view], gap))
    return min(found, key=attrgetter("gap"), default=None)


def _same_knots(a: PatchFace, axis_a: int, b: PatchFace, axis_b: int, flip: bool) -> bool:
    if a.degrees[axis_a] != b.degrees[axis_b]:
        return False
    first, second = _normalised(a.knots[axis_a]), _normalised(b.knots[axis_b])
    if flip:
        second = 1 - second[::-1]
    return len(first) == len(second) and bool(np.abs(first - second).max() <= _SAME_PARAMETER)


def _normalised(knots: Floats) -> Floats:
    return (knots - knots[0]) / (knots[-1] - knots[0])


def _touch(a: _Side, b: _Side) -> bool:
    """Return whether an end or middle of a span of a lies on b, but not on the edges of both.

    Neighbours may share an edge; faces that share more overlap.
    """
    x, normal, edge_of_a = a.samples
    low, high = b.box
    reach = TOLERANCE * min(a.face.size, b.face.size)
    candidate = np.all((x >= low - reach) & (x <= high + reach), axis=1)
    # Most neighbours share samples on an edge, which need no point location.
    on_edges = np.flatnonzero(candidate & edge_of_a)
    candidate[on_edges] = b.edge.query(x[on_edges])[0] > reach
    if not candidate.any():
        return False
    found = b.chart.locate(x[candidate], normal[candidate], reach, TOLERANCE)
    hit = ~found.missed
    inside_b = ~b.chart.on_edge(found.at.element[hit], found.at.xi[hit], 10 * TOLERANCE)
    return bool(np.any(inside_b | ~edge_of_a[candidate][hit]))
