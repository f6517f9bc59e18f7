"""Matching eigenvalues by distance, with multiplicities."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from cea.arrays import Complexes, Floats, Ints

DEGENERATE = 1e-8
"""Relative distance below which eigenvalues count as one of higher multiplicity."""


def assign(cost: Floats, limit: float | None = None) -> tuple[Ints, Ints]:
    """Return the pairs of rows (sorted) and columns with the least total cost, each used once.

    Pairs that cost more than the limit are omitted; without a limit there are min(n, m) pairs.
    """
    if limit is None:
        rows, columns = linear_sum_assignment(cost)
        return rows, columns
    n, m = cost.shape
    rows, columns = linear_sum_assignment(np.hstack([cost, np.full((n, n), limit)]))
    paired = columns < m
    return rows[paired], columns[paired]


def group(values: Complexes, tolerance: float = DEGENERATE, least: float = 0.0) -> list[Ints]:
    """Return groups of close eigenvalues, chains of near neighbours, sorted by first members.

    The tolerance is relative to the larger of two eigenvalues, and at least to ``least``, so that
    rigid body modes form one group.
    """
    sizes = np.maximum(np.abs(values), least)
    near = np.abs(values[:, None] - values) <= tolerance * np.maximum(sizes[:, None], sizes)
    return connected(near)


def connected(linked: NDArray[np.bool_]) -> list[Ints]:
    """Return connected sets of indices of a symmetric relation (n, n), sorted by first members."""
    if np.count_nonzero(linked) == np.count_nonzero(np.diag(linked)):
        return list(np.arange(len(linked))[:, None])
    count, label = connected_components(csr_array(linked), directed=False)
    return [np.flatnonzero(label == i) for i in range(count)]
