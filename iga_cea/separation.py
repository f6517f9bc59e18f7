"""Coefficients that are sums of few products of a function of the first parameter and the rest.

For boxes, arcs, and whatever is swept along the first parameter, some rows of the coefficients,
taken at few points of that parameter, span the rows at all of them:

    c[q, ...] = sum_r U[q, r] c[q_r, ...].

The rows are chosen on a few columns by QR with column pivoting (Golub & Van Loan, Matrix
Computations, sec. 5.4.2) and then held against the coefficients at every Gauss point.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular

from cea.arrays import Floats, Ints

Coefficients = dict[tuple[int, int], Floats]
"""For derivatives k of a function and m of its partner, (components, n1, n2, n3)."""

Kind = tuple[int, int]
"""Whether the function and its partner are differentiated along the first parameter, 0 or 1."""

_RANK = 1e-12
"""Pivot taken for zero, relative to the largest."""

_ROUNDING = 6 * np.finfo(float).eps
"""Difference allowed, times the degree and spans along a parameter: so inexact are slopes."""


@dataclass(frozen=True)
class Separation:
    """Rows that stand for all, for one kind of derivatives."""

    rows: Ints  # points of the first parameter
    factors: Floats  # U, (points, rows)


def kind_of(k: int, m: int) -> Kind:
    """Kind of a pair of derivatives."""
    return int(k == 0), int(m == 0)


def separate(sample: Coefficients, most: int) -> dict[Kind, Separation] | None:
    """Rows that span all rows of a sample of columns; None where they would be too many."""
    found: dict[Kind, Separation] = {}
    size = _sizes(sample).max(axis=(1, 2))
    size[size == 0] = 1.0
    for kind in sorted({kind_of(*pair) for pair in sample}):
        if kind == (1, 0):
            found[kind] = found[0, 1]  # the same coefficients, transposed
            continue
        columns = [
            np.moveaxis(c, 1, 0).reshape(len(size), -1)
            for pair, c in sample.items()
            if kind_of(*pair) == kind
        ]
        A = (np.concatenate(columns, axis=1) / size[:, None]).T
        R, order = qr(A, mode="r", pivoting=True, check_finite=False)
        pivots = np.abs(np.diag(R))
        rank = max(1, int(np.count_nonzero(pivots > _RANK)))
        most -= rank
        if most < 0:
            return None
        share = solve_triangular(R[:rank, :rank], R[:rank, rank:]) if pivots[0] > 0 else 0.0
        factors = np.zeros((len(size), rank))
        factors[order[:rank]] = np.eye(rank)
        factors[order[rank:]] = np.transpose(share)
        rows = order[:rank]
        found[kind] = Separation(rows, size[:, None] * factors / size[rows])
    return found


def holds(
    separations: dict[Kind, Separation],
    skeleton: Callable[[tuple[int, int]], Floats],
    layers: Iterator[tuple[slice, Coefficients]],
    steepness: int,
) -> bool:
    """Whether separations give back the coefficients at every point.

    Differences are relative to the largest coefficient at the same point.
    """
    for points, layer in layers:
        allowed = steepness * _ROUNDING * _sizes(layer)
        for (k, m), exact in layer.items():
            if k > m:
                continue  # the transpose of another
            U = separations[kind_of(k, m)].factors[points]
            rows = skeleton((k, m))
            difference = (U @ rows.reshape(*rows.shape[:2], -1)).reshape(exact.shape)
            difference -= exact
            if not np.all(np.abs(difference, out=difference).max(axis=0) <= allowed):
                return False
    return True


def _sizes(coefficients: Coefficients) -> Floats:
    """Largest coefficient at each point."""
    return np.max([np.abs(c).max(axis=0) for c in coefficients.values()], axis=0)
