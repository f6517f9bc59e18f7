"""Orthogonal compression of many dependent rows to few, sparse: a multifrontal QR factorisation.

Points of a rule are many, the gaps that traces can tell apart few. For rows G and T at points

    G = Q J,     R = Q^T T,     Q^T Q = I,

with J of full row rank: G^T G = J^T J and T^T G = R^T J. Points are divided in halves again and
again. Going up that tree, a column that no point outside a part touches is eliminated within the
part, and what remains on the columns at its edge is handed on (Duff and Reid 1983; Davis, ACM
Trans. Math. Softw. 38, 2011). Rank is judged column by column (Heath 1982).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints
from cea.petsc import MPI

_DEPENDENT = 1e-12
"""Rows whose pivot is below this part of their column are taken to depend on those before."""
_NEGLIGIBLE = 1e-12  # entries below this part of their row are rounding
_FADED = 1e-14
"""What is left of a column of T, relative to its length, that is rounding: with uniform friction a
column is gone from T where G has it no more."""
_BLOCKED = 64  # columns that LAPACK works on at a time, for which it wants room
_LEAF = 160  # points that are worked on at once


@dataclass(frozen=True)
class _Front:
    """Rows that remain of a part of the points."""

    rows: Floats  # on the columns of G at the edge of the part, (k, n)
    # these columns, rising, and how many points of the part touch each, (n,)
    columns: Ints
    touching: Ints
    # the rows of T that go with them, and their columns, rising
    carried: Floats
    carried_columns: Ints


def compressed(gap: csr_array, slip: csr_array, x: Floats, comm: Any) -> tuple[csr_array, ...]:
    """J and R of rows G and T at points, the rows that this rank is left with.

    Each rank compresses its own points; rank 0 what remains between them.
    """
    gap = _without(gap, _rounding(gap, comm))
    squares = np.bincount(gap.indices, gap.data**2, gap.shape[1])
    size = np.sqrt(comm.allreduce(squares, MPI.SUM))
    touching = np.bincount(gap.indices, minlength=gap.shape[1])
    slip = _without(slip, np.zeros(slip.shape[1], dtype=bool))
    squares = np.bincount(slip.indices, slip.data**2, slip.shape[1])
    least = _FADED * np.sqrt(comm.allreduce(squares, MPI.SUM))
    compression = _Compression(gap, slip, size, comm.allreduce(touching, MPI.SUM), least)
    rest = compression.of_points(np.arange(gap.shape[0]), x)
    if comm.size > 1:
        parts = comm.gather(rest)
        if comm.rank == 0:
            compression.finish(_joined(parts))
    return (
        _assembled(compression.closure, gap.shape[1]),
        _assembled(compression.reaction, slip.shape[1]),
    )


def _rounding(gap: csr_array, comm: Any) -> NDArray[np.bool_]:
    """Columns that are nothing but rounding in every row: of normals along axes."""
    row = np.repeat(np.arange(gap.shape[0]), np.diff(gap.indptr))
    length = np.sqrt(np.bincount(row, gap.data**2, gap.shape[0]))
    largest = np.zeros(gap.shape[1])
    part = np.abs(gap.data) / np.maximum(length[row], np.finfo(float).tiny)
    np.maximum.at(largest, gap.indices, part)
    comm.Allreduce(MPI.IN_PLACE, largest, MPI.MAX)
    return largest <= _NEGLIGIBLE


def _without(matrix: csr_array, columns: NDArray[np.bool_]) -> csr_array:
    """A matrix without its zeros, and without some columns."""
    result = matrix.copy()
    result.data[columns[result.indices]] = 0.0
    result.eliminate_zeros()
    return result


@dataclass
class _Compression:
    """The tree of rows G and T at points, worked through from its leaves.

    Of each column of G the length over all points and the number of points that touch it are known,
    and what is rounding of each column of T.
    """

    gap: csr_array
    slip: csr_array
    size: Floats
    touching: Ints
    least: Floats
    # rows of J and R that are done: dense blocks and their columns
    closure: list[tuple[Floats, Ints]] = field(default_factory=list)
    reaction: list[tuple[Floats, Ints]] = field(default_factory=list)

    def of_points(self, points: Ints, x: Floats) -> _Front:
        """What remains of some points once all that is theirs alone is done."""
        if len(points) <= _LEAF:
            return self.finish(self._leaf(points))
        halves = _halves(points, x)
        return self.finish(_joined([self.of_points(half, x) for half in halves]))

    def _leaf(self, points: Ints) -> _Front:
        gap, slip = self.gap[points], self.slip[points]
        columns, count = np.unique(gap.indices, return_counts=True)
        carried = np.unique(slip.indices)
        return _Front(
            gap[:, columns].toarray(), columns, count, slip[:, carried].toarray(), carried
        )

    def finish(self, front: _Front) -> _Front:
        """Eliminate the columns that no other point touches; what remains."""
        own = front.touching == self.touching[front.columns]
        inner, edge = front.columns[own], front.columns[~own]
        size = self.size[front.columns]
        # Of rows of very different size the large ones go first: small ones keep their digits.
        order = np.argsort(-np.abs(front.rows).max(axis=1, initial=0.0), kind="stable")
        rows, carried = front.rows[order] / size, front.carried[order]
        rest = rows[:, ~own]
        if len(inner) and len(rows):
            room = _BLOCKED * (len(inner) + 2)
            factors, pivots, reflections, _, _ = lapack.dgeqp3(rows[:, own], room)
            rank = int(np.sum(np.abs(np.diag(factors)) > _DEPENDENT))
            rest = _reflected(factors, reflections, rest)
            carried = _reflected(factors, reflections, carried)
            done = np.empty((rank, len(front.columns)))
            done[:, np.flatnonzero(own)[pivots - 1]] = np.triu(factors)[:rank]
            done[:, ~own] = rest[:rank]
            self.closure.append((done * size, front.columns))
            self.reaction.append((carried[:rank], front.carried_columns))
            rest, carried = rest[rank:], carried[rank:]
        if len(rest) > len(edge):
            if len(edge):
                factors, reflections, _, _ = lapack.dgeqrf(rest, _BLOCKED * len(edge))
                carried = _reflected(factors, reflections, carried)
                rest = np.triu(factors)
            rest, carried = rest[: len(edge)], carried[: len(edge)]
        lasting = np.abs(carried).max(axis=0, initial=0.0) > self.least[front.carried_columns]
        return _Front(
            rest * size[~own],
            edge,
            front.touching[~own],
            carried[:, lasting],
            front.carried_columns[lasting],
        )


def _halves(points: Ints, x: Floats) -> list[Ints]:
    """Two parts of equal size, one beside the other along the longest side of all of them."""
    along = x[points][:, np.ptp(x[points], axis=0).argmax()]
    order = np.argsort(along, kind="stable")
    return [points[half] for half in np.array_split(order, 2)]


def _reflected(factors: Floats, reflections: Floats, block: Floats) -> Floats:
    """Q^T times a block, of a QR factorisation as LAPACK keeps it."""
    if block.shape[1] == 0:
        return block
    factors, room = factors[:, : len(reflections)], _BLOCKED * (block.shape[1] + _BLOCKED)
    result: Floats = lapack.dormqr("L", "T", factors, reflections, block, room)[0]
    return result


def _joined(parts: Sequence[_Front]) -> _Front:
    """Fronts of several parts as one."""
    columns = np.unique(np.concatenate([p.columns for p in parts]))
    carried_columns = np.unique(np.concatenate([p.carried_columns for p in parts]))
    touching = np.zeros(len(columns), dtype=np.int64)
    count = sum(len(p.rows) for p in parts)
    rows, carried = np.zeros((count, len(columns))), np.zeros((count, len(carried_columns)))
    first = 0
    for part in parts:
        last = first + len(part.rows)
        at = np.searchsorted(columns, part.columns)
        rows[first:last, at] = part.rows
        touching[at] += part.touching
        carried[first:last, np.searchsorted(carried_columns, part.carried_columns)] = part.carried
        first = last
    return _Front(rows, columns, touching, carried, carried_columns)


def _assembled(blocks: Sequence[tuple[Floats, Ints]], columns: int) -> csr_array:
    """Dense blocks one below the other, each in its columns."""
    lengths = [np.full(len(block), len(at)) for block, at in blocks]
    indptr = np.concatenate([[0], np.cumsum(np.concatenate([np.empty(0, int), *lengths]))])
    data = np.concatenate([np.empty(0), *(block.ravel() for block, _ in blocks)])
    indices = [np.tile(at, len(block)) for block, at in blocks]
    matrix = csr_array(
        (data, np.concatenate([np.empty(0, np.int64), *indices]), indptr.astype(np.int64)),
        shape=(len(indptr) - 1, columns),
    )
    matrix.eliminate_zeros()
    return matrix
