"""Orthogonal compression of many dependent sparse rows to few, by multifrontal QR factorisation.

A rule has more points than the traces have independent gaps. For rows G and T at points

    G = Q J,     R = Q^T T,     Q^T Q = I,

with J of full row rank: G^T G = J^T J and T^T G = R^T J. Points are bisected recursively. From the
leaves of that tree upwards, columns that no point outside a part touches are eliminated in the
part, and the rest, on the columns at its boundary, is passed to the parent (Duff and Reid 1983;
Davis, ACM Trans. Math. Softw. 38, 2011). Rank is determined column by column (Heath 1982).
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse import csr_array, vstack

from cea.arrays import Floats, Ints
from cea.petsc import MPI

_DEPENDENT = 1e-12
"""Pivot, relative to its column, below which a row is treated as linearly dependent."""
_NEGLIGIBLE = 1e-12  # entries below this, relative to their row, are dropped as rounding
_FADED = 1e-14
"""Drop tolerance for the rest of a column of T, relative to its norm: with uniform friction a
column of T vanishes when the same column of G is eliminated."""
_BLOCKED = 64  # block size of LAPACK's workspace
_LEAF = 160  # points of a leaf of the tree

type Rows = tuple[csr_array, csr_array]
"""Rows of G and the corresponding rows of T."""


def compressed(gap: csr_array, slip: csr_array, x: Floats, comm: Any) -> Rows:
    """Return the rows of J and R that remain on this rank, for rows G and T at points.

    Each rank compresses its own points; rank 0 compresses what remains of all ranks.
    """
    order = _bisected(np.arange(len(x)), x)
    rounding, gap, slip = _rounding(gap, comm), gap[order], slip[order]
    gap.data[rounding[gap.indices]] = 0.0
    gap.eliminate_zeros()
    slip.eliminate_zeros()
    row, columns = np.repeat(np.arange(len(x)), np.diff(gap.indptr)), gap.shape[1]
    first, last = np.full(columns, len(x)), np.full(columns, -1)
    np.minimum.at(first, gap.indices, row)
    np.maximum.at(last, gap.indices, row)
    first[comm.allreduce((last >= 0).astype(int), MPI.SUM) > 1] = -1  # touched on several ranks
    size, length = (
        np.sqrt(comm.allreduce(np.bincount(m.indices, m.data**2, m.shape[1]), MPI.SUM))
        for m in (gap, slip)
    )
    compression = _Compression(size, _FADED * length, first, last)
    rest = compression.of_points((gap, slip), 0)
    if comm.size > 1:
        parts = comm.gather(rest)
        if comm.rank == 0:
            compression.finish(_stacked(parts), -1, len(x))
    nothing = csr_array((0, columns)), csr_array((0, slip.shape[1]))
    closure, reaction = _stacked([nothing, *compression.done])
    closure.eliminate_zeros()
    reaction.eliminate_zeros()
    return closure, reaction


def _bisected(points: Ints, x: Floats) -> Ints:
    """Order points by recursive bisection along the longest side of their bounding box."""
    if len(points) <= _LEAF:
        return points
    along = x[points][:, np.ptp(x[points], axis=0).argmax()]
    halves = np.array_split(points[np.argsort(along, kind="stable")], 2)
    return np.concatenate([_bisected(half, x) for half in halves])


def _rounding(gap: csr_array, comm: Any) -> NDArray[np.bool_]:
    """Return columns that are only rounding in every row, as for normals along axes."""
    row = np.repeat(np.arange(gap.shape[0]), np.diff(gap.indptr))
    length = np.sqrt(np.bincount(row, gap.data**2, gap.shape[0]))
    largest = np.zeros(gap.shape[1])
    part = np.abs(gap.data) / np.maximum(length[row], np.finfo(float).tiny)
    np.maximum.at(largest, gap.indices, part)
    comm.Allreduce(MPI.IN_PLACE, largest, MPI.MAX)
    return largest <= _NEGLIGIBLE


@dataclass
class _Compression:
    """Elimination tree of rows G and T at bisected points, processed from its leaves."""

    size: Floats  # norm of each column of G over all points
    least: Floats  # norm below which each column of T is rounding
    # the first and the last point that touches each column of G; -1 where several ranks touch it
    first: Ints
    last: Ints
    done: list[Rows] = field(default_factory=list)  # finished rows of J and R

    def of_points(self, rows: Rows, start: int) -> Rows:
        """Eliminate the interior columns of consecutive points; return the remaining rows."""
        count = rows[0].shape[0]
        if count > _LEAF:
            middle = (count + 1) // 2
            one, other = (rows[0][:middle], rows[1][:middle]), (rows[0][middle:], rows[1][middle:])
            rows = _stacked([self.of_points(one, start), self.of_points(other, start + middle)])
        return self.finish(rows, start, start + count)

    def finish(self, given: Rows, start: int, stop: int) -> Rows:
        """Eliminate the columns that only points start to stop touch; return the remaining rows."""
        columns, carried_columns = (np.unique(part.indices) for part in given)
        rows, carried = given[0][:, columns].toarray(), given[1][:, carried_columns].toarray()
        own = (self.first[columns] >= start) & (self.last[columns] < stop)
        inner, edge, size = columns[own], columns[~own], self.size[columns]
        # Large rows first: otherwise small rows lose digits.
        order = np.argsort(-np.abs(rows).max(axis=1, initial=0.0), kind="stable")
        rows, carried = rows[order] / size, carried[order]
        rest = rows[:, ~own]
        if len(inner) and len(rows):
            room = _BLOCKED * (len(inner) + 2)
            factors, pivots, reflections, _, _ = lapack.dgeqp3(rows[:, own], room)
            rank = int(np.sum(np.abs(np.diag(factors)) > _DEPENDENT))
            rest = _reflected(factors, reflections, rest)
            carried = _reflected(factors, reflections, carried)
            done = np.empty((rank, len(columns)))
            done[:, np.flatnonzero(own)[pivots - 1]] = np.triu(factors)[:rank]
            done[:, ~own] = rest[:rank]
            closure = _in_columns(done * size, columns, given[0])
            self.done.append((closure, _in_columns(carried[:rank], carried_columns, given[1])))
            rest, carried = rest[rank:], carried[rank:]
        if len(rest) > len(edge):
            if len(edge):
                factors, reflections, _, _ = lapack.dgeqrf(rest, _BLOCKED * len(edge))
                carried = _reflected(factors, reflections, carried)
                rest = np.triu(factors)
            rest, carried = rest[: len(edge)], carried[: len(edge)]
        lasting = np.abs(carried).max(axis=0, initial=0.0) > self.least[carried_columns]
        return (
            _in_columns(rest * size[~own], edge, given[0]),
            _in_columns(carried[:, lasting], carried_columns[lasting], given[1]),
        )


def _reflected(factors: Floats, reflections: Floats, block: Floats) -> Floats:
    """Return Q^T times a block, for a QR factorisation in LAPACK's storage."""
    if block.shape[1] == 0:
        return block
    factors, room = factors[:, : len(reflections)], _BLOCKED * (block.shape[1] + _BLOCKED)
    result: Floats = lapack.dormqr("L", "T", factors, reflections, block, room)[0]
    return result


def _stacked(parts: list[Rows]) -> Rows:
    """Stack the rows of several parts."""
    gap, slip = (csr_array(vstack(each, format="csr")) for each in zip(*parts, strict=True))
    return gap, slip


def _in_columns(block: Floats, columns: Ints, like: csr_array) -> csr_array:
    """Return a dense block as sparse rows with given columns."""
    count, width = block.shape
    entries = (block.ravel(), np.tile(columns, count), width * np.arange(count + 1))
    return csr_array(entries, shape=(count, like.shape[1]))
