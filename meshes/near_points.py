"""Points that lie together."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints


def first_of_near(points: Floats, distance: float) -> Ints:
    """Number of the first of the points that a chain of steps below a distance joins to each."""
    pairs = cKDTree(points).query_pairs(distance, output_type="ndarray")
    size = len(points)
    links = coo_array((np.ones(len(pairs), dtype=bool), tuple(pairs.T)), shape=(size, size))
    _, group = connected_components(links, directed=False)
    return np.unique(group, return_index=True)[1][group].astype(np.int64)
