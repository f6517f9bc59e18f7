"""Separation of coefficients into few products of functions of the first parameter and the rest.

For boxes, arcs, and bodies swept along the first parameter, the rows of the coefficients at few
points of that parameter span the rows at all points:

    c[q, ...] = sum_r U[q, r] c[q_r, ...].

The rows are selected on a few columns by QR with column pivoting (Golub & Van Loan, Matrix
Computations, sec. 5.4.2), and the result is verified at every Gauss point.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular

from cea.arrays import Floats, Ints

Coefficients = dict[tuple[int, int], Floats]
"""By derivatives k of a function and m of its partner, (components, n1, n2, n3)."""

Kind = tuple[int, int]
"""Whether the function and its partner are differentiated along the first parameter, 0 or 1."""

_RANK = 1e-12
"""Pivot, relative to the largest, below which it is zero."""

_ROUNDING = 6 * np.finfo(float).eps
"""Tolerance per degree and span of a parameter, the rounding error of slopes."""


@dataclass(frozen=True)
class Separation:
    """Selected rows and factors, for one kind of derivatives."""

    rows: Ints  # points of the first parameter
    factors: Floats  # U, (points, rows)


def kind_of(k: int, m: int) -> Kind:
    """Return the kind of a pair of derivatives."""
    return int(k == 0), int(m == 0)


def separate(sample: Coefficients, most: int) -> dict[Kind, Separation] | None:
    """Return rows that span all rows of a sample of columns; None if more than ``most``."""
    found: dict[Kind, Separation] = {}
    size = _sizes(sample).max(axis=(1, 2))
    size[size == 0] = 1.0
    for kind in sorted({kind_of(*pair) for pair in sample}):
        if kind == (1, 0):
            found[kind] = found[0, 1]  # the transposed coefficients
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
    """Return whether separations reproduce the coefficients at every point.

    Differences are relative to the largest coefficient at the same point.
    """
    for points, layer in layers:
        allowed = steepness * _ROUNDING * _sizes(layer)
        for (k, m), exact in layer.items():
            if k > m:
                continue  # transpose of a pair that is checked
            U = separations[kind_of(k, m)].factors[points]
            rows = skeleton((k, m))
            difference = (U @ rows.reshape(*rows.shape[:2], -1)).reshape(exact.shape)
            difference -= exact
            if not np.all(np.abs(difference, out=difference).max(axis=0) <= allowed):
                return False
    return True


def _sizes(coefficients: Coefficients) -> Floats:
    """Return the largest coefficient at each point."""
    return np.max([np.abs(c).max(axis=0) for c in coefficients.values()], axis=0)
