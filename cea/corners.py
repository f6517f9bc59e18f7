"""Where the normal of a surface jumps: what reaches over a corner is split by normal.

A contact closes gaps along one normal at each point. A trace function that reaches over a corner
would average gaps along two: it is split into one function for each smooth part of the surface that
it reaches. A point at a corner likewise becomes one point for each smooth part, with the normal and
the area of that part.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cea.arrays import Floats, Ints

TANGENT = np.cos(np.deg2rad(1.0))
"""Least cosine between normals of faces that join smoothly.

Programs that draw faces take them for tangent within about a degree.
"""


def pairs_of_equal(numbers: Ints) -> Ints:
    """All pairs of entries that have the same number, shape (pairs, 2)."""
    order = np.argsort(numbers, kind="stable")
    rising = numbers[order]
    pairs = [np.empty((0, 2), dtype=np.int64)]
    for apart in range(1, len(rising)):
        same = np.flatnonzero(rising[apart:] == rising[:-apart])
        if not same.size:
            break
        pairs.append(np.column_stack([order[same], order[same + apart]]))
    return np.concatenate(pairs)


def connected(pairs: Ints, count: int) -> Ints:
    """Group of each of ``count`` entries: paired entries are in one, numbers from 0."""
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def split_functions(dofs: Ints, groups: Ints, count: int) -> Ints:
    """Number of the split function of each entry, an entry for each function on each element."""
    _, first = np.unique(groups, return_index=True)
    number = dofs[first]
    further = np.ones(len(first), dtype=bool)
    further[np.unique(number, return_index=True)[1]] = False
    number[further] = count + np.arange(further.sum())
    return number[groups]


def smooth_parts(element: Ints, functions: Ints, num_elements: int) -> Ints:
    """Smooth part of each element: elements that share a split function are in one."""
    count = num_elements + int(functions.max(initial=0)) + 1
    pairs = np.column_stack([element, num_elements + functions])
    return connected(pairs, count)[:num_elements]


def equal_shares(part: Ints, areas: Floats, area: float) -> Floats:
    """Weights of points of which each has the same share of the area of its smooth part."""
    number = np.maximum(np.bincount(part, minlength=len(areas)), 1)
    return (area * (areas / areas.sum()) / number)[part]
