"""Candidates of point location: which cells of a surface a line through a point may meet."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints
from cea.surface_points import SurfaceCells, lattice

_SIDE = 4
"""Parts of a side of a cell between samples."""
_SAFETY = 1.5
"""Margin on the sampled distance of a bent cell from the flat one of its corners."""
_NEAR = 1.05
"""Lines that pass a cell's ball by less than this part of its radius are tried: near misses."""


class Boxes:
    """Boxes with sides along the axes, in trees of their centres, one for each size.

    Parameters
    ----------
    low, high
        Least and greatest coordinates (m), shape (n, dim).
    """

    def __init__(self, low: Floats, high: Floats) -> None:
        self.low, self.high = low, high

    @cached_property
    def _trees(self) -> list[tuple[Ints, cKDTree, float]]:
        """Boxes of like size, a tree of their centres, their half extent (m)."""
        half = 0.5 * (self.high - self.low).max(axis=1)
        centre = 0.5 * (self.low + self.high)
        kind = np.frexp(half)[1]
        every = [np.flatnonzero(kind == each) for each in np.unique(kind)]
        return [(some, _tree(centre[some]), float(half[some].max())) for some in every]

    def within(self, x: Floats, reach: float) -> tuple[Ints, Ints]:
        """Points (m), shape (m, dim), and boxes that come within reach of them, one pair a row."""
        points, boxes, tree = [], [], _tree(x)
        for some, centres, half in self._trees:
            pairs = tree.sparse_distance_matrix(
                centres, half + reach, p=np.inf, output_type="ndarray"
            )
            point, box = pairs["i"].astype(np.int64), some[pairs["j"]]
            at = x[point]
            near = ((at >= self.low[box] - reach) & (at <= self.high[box] + reach)).all(axis=1)
            points.append(point[near])
            boxes.append(box[near])
        return np.concatenate(points), np.concatenate(boxes)


def _tree(x: Floats) -> cKDTree:
    """Tree that is quick to make: it is asked once or twice."""
    return cKDTree(x, balanced_tree=False, compact_nodes=False)


class CellBounds:
    """Boxes and balls that hold the cells of a surface.

    Parameters
    ----------
    cells
        The cells.
    tangents
        Positions and derivatives of the surface (:meth:`cea.surface.Surface.tangents`).
    """

    def __init__(
        self, cells: SurfaceCells, tangents: Callable[[Ints, Floats], tuple[Floats, Floats]]
    ) -> None:
        self._element = cells.element
        steps = lattice(_SIDE, cells.corners.shape[2], simplex=not cells.tensor)
        t = steps / _SIDE
        at, _ = cells.coordinates(t)
        x = tangents(at.element, at.xi)[0].reshape(len(cells.element), len(t), -1)
        corner = np.flatnonzero(np.isin(steps, (0, _SIDE)).all(axis=1))
        if cells.tensor:
            ends = steps[corner] == _SIDE
            shape = np.where(ends, t[:, None], 1 - t[:, None]).prod(axis=2)
        else:  # corners in C order: the first, that along the second direction, along the first
            shape = np.column_stack([1 - t.sum(axis=1), t[:, ::-1]])
        corners = x[:, corner]
        bulge = np.abs(x - shape @ corners).max(axis=1)
        margin = _SAFETY * bulge
        self.boxes = Boxes(corners.min(axis=1) - margin, corners.max(axis=1) + margin)
        self.centre = corners.mean(axis=1)
        farthest = np.linalg.norm(corners - self.centre[:, None], axis=2).max(axis=1)
        self.radius = farthest + np.linalg.norm(margin, axis=1)
        # Not on the edges: a collapsed one has no tangent to start Newton's method with.
        inner = (steps > 0).all(axis=1)
        inner &= (steps.sum(axis=1) if not cells.tensor else steps.max(axis=1)) < _SIDE
        self._starts = at.xi.reshape(*x.shape[:2], -1)[:, inner]
        self._samples = x[:, inner]

    def candidates(self, x: Floats, direction: Floats, reach: float) -> tuple[Ints, Ints, Floats]:
        """Pairs worth trying: points, elements, and xi of the sample nearest to the line.

        To the line as far as it reaches: of a bent cell it may meet more beyond.
        """
        # Room for rounding, beside a reach that may be zero.
        room = reach + 1e-6 * 2 * float(self.radius.max())
        point, cell = self.boxes.within(x, room)
        aim = direction[point]
        along, across = _apart(self.centre[cell] - x[point], aim)
        near = _NEAR * self.radius[cell]
        tried = (across <= near) & (np.abs(along) <= reach + near)
        point, cell, aim = point[tried], cell[tried], aim[tried]
        offset = self._samples[cell] - x[point][:, None]
        along, across = _apart(offset, aim[:, None])
        best = np.hypot(across, np.maximum(np.abs(along) - reach, 0.0)).argmin(axis=1)
        return point, self._element[cell], self._starts[cell, best]


def _apart(offset: Floats, aim: Floats) -> tuple[Floats, Floats]:
    """Parts of offsets along unit directions, and how far across, (...,) each."""
    along = (offset * aim).sum(axis=-1)
    return along, np.linalg.norm(offset - along[..., None] * aim, axis=-1)
