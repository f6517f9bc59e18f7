"""Faces of patches as point location sees them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from cea.arrays import Floats, Ints
from cea.location import newton_step
from iga_cea.chunks import chunks
from iga_cea.face import PatchFace
from iga_cea.grids import grid_points
from iga_cea.patch import subdivided

_SAMPLES = (4, 2)
"""Pieces of each knot span between samples, per direction: of few spans, and of many."""

_MANY = 16
"""Spans along a direction that are many."""

_BLOCKS = 3
"""Blocks of samples of each face, per direction: each may start its own Newton iteration."""

_STUCK = 1e-9
"""Tangent of a collapsed edge, relative to the longest."""

_ASIDE = 0.1
"""Part of the way to the middle of its block by which a start leaves a collapsed edge."""


@dataclass(frozen=True)
class _Block:
    """Samples of a part of a face; every point of the part lies within ``radius`` of one.

    With positions and tangents for a first step of Newton's method; none on collapsed edges, where
    ``xi`` has been moved aside.
    """

    element: int
    xi: Floats
    tree: KDTree
    tangents: Floats
    stuck: NDArray[np.bool_]
    radius: float

    def starts(self, x: Floats, direction: Floats, reach: float) -> tuple[Ints, Floats]:
        """Points that may meet the part within a reach, and xi to start from."""
        # A relative margin: a point just at the reach must not be lost to rounding.
        bound = (reach + self.radius) * (1 + 1e-9)
        boxed = (x >= self.tree.mins - bound) & (x <= self.tree.maxes + bound)
        near = np.flatnonzero(boxed.all(axis=1))
        distance, nearest = self.tree.query(x[near], distance_upper_bound=bound)
        found = np.isfinite(distance)
        near, nearest = near[found], nearest[found]
        rest = x[near] - self.tree.data[nearest]
        step = newton_step(self.tangents[nearest], direction[near], rest)
        step[self.stuck[nearest]] = 0.0
        return near, self.xi[nearest] + step


@dataclass(frozen=True)
class _Flat:
    """A whole face that parameters map affinely: one step of Newton's method ends anywhere on it.

    Parameters
    ----------
    element
        Number of the face.
    middle
        Its middle parameters, (dim - 1,).
    low, high
        Least and greatest coordinates (m), (dim,).
    """

    element: int
    middle: Floats
    low: Floats
    high: Floats

    def starts(self, x: Floats, direction: Floats, reach: float) -> tuple[Ints, Floats]:
        """Points that may meet the face within a reach, and xi to start from."""
        bound = reach + 1e-9 * (reach + float((self.high - self.low).max()))
        boxed = (x >= self.low - bound) & (x <= self.high + bound)
        near = np.flatnonzero(boxed.all(axis=1))
        return near, np.broadcast_to(self.middle, (len(near), len(self.middle)))


class FaceChart:
    """Faces of patches, numbered in order, as elements of a surface.

    Parameters
    ----------
    faces
        The faces.
    """

    def __init__(self, faces: Sequence[PatchFace]) -> None:
        self.faces = tuple(faces)

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return self.faces[0].dim

    def candidates(self, x: Floats, direction: Floats, reach: float) -> tuple[Ints, Ints, Floats]:
        """Pairs worth trying: point numbers, faces, starting xi.

        An answer y lies within ``reach`` of its point, and some sample of y's block within the
        block's radius of y, so that sample lies within reach + radius of the point: no block that
        holds an answer is left out. Each block in reach starts from a step of Newton's method at
        its sample nearest the point. A short reach leaves one or two starts, all near the answer;
        a long one, under which Newton's method could be drawn to the wrong end of a curved face,
        leaves starts all over it. A flat face of even parameters needs one.
        """
        points, elements, starts = [], [], []
        for block in self._blocks:
            near, xi = block.starts(x, direction, reach)
            points.append(near)
            elements.append(np.full(len(near), block.element))
            starts.append(xi)
        return np.concatenate(points), np.concatenate(elements), np.concatenate(starts)

    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        x = np.empty((len(element), self.dim))
        derivatives = np.empty((len(element), self.dim, self.dim - 1))
        for face, rows in self.pieces(element):
            x[rows], derivatives[rows] = face.tangents(xi[rows])
        return x, derivatives

    def clamp(self, element: Ints, xi: Floats) -> Floats:
        """Nearest parameters inside the face."""
        low, high = self._range
        return np.clip(xi, low[element], high[element])

    def on_edge(self, element: Ints, xi: Floats, tolerance: float) -> np.ndarray:
        """True where xi lies on the boundary of the face, within a fraction of its range."""
        low, high = (ends[element] for ends in self._range)
        inside = np.minimum(xi - low, high - xi)
        return (inside <= tolerance * (high - low)).any(axis=1)

    def size(self, element: Ints) -> Floats:
        """Diameter (m) of the largest knot span of each face."""
        return np.array([face.size for face in self.faces])[element]

    def pieces(self, element: Ints) -> Iterator[tuple[PatchFace, Ints]]:
        """Each face with the rows of its points, a chunk at a time."""
        for number, face in enumerate(self.faces):
            rows = np.flatnonzero(element == number)
            for part in chunks(len(rows), 8 * 2 * face.functions * (3 * self.dim + 2)):
                yield face, rows[part]

    @cached_property
    def _range(self) -> tuple[Floats, Floats]:
        """Least and greatest parameters of each face, both (faces, dim - 1)."""
        ends = np.array([[knots[[0, -1]] for knots in face.knots] for face in self.faces])
        return ends[:, :, 0], ends[:, :, 1]

    @cached_property
    def _blocks(self) -> list[_Block | _Flat]:
        return [
            block for number, face in enumerate(self.faces) for block in _blocks_of(number, face)
        ]


def _blocks_of(number: int, face: PatchFace) -> Iterator[_Block | _Flat]:
    """Cut the spans of a face into blocks and sample each, boundary included."""
    if face.affine is not None:
        ends = grid_points(tuple(knots[[0, -1]] for knots in face.knots))
        corners = face.tangents(ends)[0]
        yield _Flat(number, ends.mean(axis=0), corners.min(axis=0), corners.max(axis=0))
        return
    parts = []
    for breaks in face.breaks:
        spans = np.array_split(np.arange(len(breaks) - 1), min(_BLOCKS, len(breaks) - 1))
        samples = _SAMPLES[len(breaks) > _MANY]
        parts.append([subdivided(breaks[s[0] : s[-1] + 2], samples) for s in spans])
    for parameters in product(*parts):
        xi = grid_points(parameters)
        x, tangents = face.tangents_on(parameters)
        # A collapsed edge has no tangent along it to start Newton's method with.
        speed = np.linalg.norm(tangents, axis=1)
        stuck = speed.min(axis=1) <= _STUCK * speed.max()
        xi[stuck] += _ASIDE * (xi.mean(axis=0) - xi[stuck])
        net = x.reshape(*(len(p) for p in parameters), face.dim)
        # Twice the half diagonal of a cell of samples: room for its curvature.
        sides = [np.linalg.norm(np.diff(net, axis=k), axis=-1).max() for k in range(face.dim - 1)]
        yield _Block(number, xi, KDTree(x), tangents, stuck, float(sum(sides)))
