"""Which boxes come near points: trees of the boxes' centres, one for each size."""

from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints


class Boxes:
    """Boxes with sides along the axes.

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
