"""Contact with forces as Lagrange multipliers: the saddle form, and all mortar contact.

    [ K   L^T  ] [x]   [r]
    [ J   -C/P ] [f] = [0],     L = J - R,

Eliminating f gives the penalty form: P L^T C^-1 J = K_n - K_f. The saddle form loses no digits as
P grows, and P = infinity ties the sides along the normal but keeps friction. With
p = P p^,

    points:   sqrt(W p^) G = Q J,     R = Q^T sqrt(W p^) diag(mu) T,     C = 1
    mortar:   J = B,                  R = B_k,                           C_ij = int psi_i psi_j / p^

all of them sparse. A rule has more points than the traces have independent gaps: orthogonal
compression by multifrontal QR factorisation drops dependent rows. For rows G and T at points

    G = Q J,     R = Q^T T,     Q^T Q = I,

with J of full row rank: G^T G = J^T J and T^T G = R^T J. Points are bisected recursively. From the
leaves of that tree upwards, columns that no point outside a part touches are eliminated in the
part, and the rest, on the columns at its boundary, is passed to the parent (Duff and Reid 1983;
Davis, ACM Trans. Math. Softw. 38, 2011). Rank is determined column by column (Heath 1982).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse import csr_array, diags_array, vstack

from cea.arrays import Floats, Ints
from cea.contact.contact import Contact, by_pair, powers_of
from cea.eigen.coefficients import NOTHING, Coefficient
from cea.eigen.multipliers import ForcesOfContact
from cea.matrices import (
    applied,
    block_diagonal,
    destroy,
    diagonal_of,
    distributed,
    identity,
    local_part,
    of_entries,
    one_below_the_other,
)
from cea.petsc import MPI

_UNFELT = 1e-24
"""Relative stiffness of a force, compared with the largest of a contact, treated as zero."""
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


def forces_of_contacts(contacts: Sequence[Contact], stiffness: Floats) -> Iterator[ForcesOfContact]:
    """Yield the multipliers of each contact that has any; collective.

    ``stiffness`` is the diagonal of K of the bodies (N/m), the rows of this rank.
    """
    for name, halves in with_multipliers(contacts).items():
        made = (_at_points if halves[0].traces is None else _projected)(halves)
        closure, slip, compliance = made
        inverse = Coefficient({f"contacts.{name}.P": (1.0, -1.0)})
        if not halves[0].law.linear:
            inverse = Coefficient({}, factor=1 / sum(half.P for half in halves))
        mu = NOTHING if slip is None else Coefficient(powers_of(halves)[1])
        soft = _body_stiffness(closure, compliance, stiffness)
        yield ForcesOfContact(closure, slip, compliance, inverse, mu, soft)


def with_multipliers(contacts: Sequence[Contact]) -> dict[str, list[Contact]]:
    """Return half passes with multipliers by contact, except between sides without free dofs.

    The halves of a full pass share one P.
    """
    return {
        name: halves
        for name, halves in by_pair([each for each in contacts if each.has_multipliers]).items()
        if any(half.gap.norm() > 0 for half in halves)
    }


def few_forces(halves: Sequence[Contact], carried: Sequence[csr_array]) -> tuple[csr_array, ...]:
    """Return J, and Q^T sqrt(W p^) times other rows at the points; the rows of this rank."""
    gaps, others, places = [], [], []
    for half, share, rows in zip(halves, _relative_stiffness(halves), carried, strict=True):
        weight = half.weight(share)
        closed = np.flatnonzero(weight)  # open points have no force
        root = diags_array(np.sqrt(weight[closed]))
        gaps.append(csr_array(root @ local_part(half.gap)[closed]))
        others.append(csr_array(root @ rows[closed]))
        places.append(half.interface.local_points.x[closed])
    gap, other = (csr_array(vstack(parts)) for parts in (gaps, others))
    return compressed(gap, other, np.concatenate(places), halves[0].interface.comm)


def _relative_stiffness(halves: Sequence[Contact]) -> list[Floats]:
    """Return p^ = p / P of each half at all points (1/m^2), P of both halves; uniform if tied."""
    if any(half.tied for half in halves):
        weights = [half.interface.points.weight for half in halves]
        return [np.full(len(w), 1 / (len(halves) * w.sum())) for w in weights]
    P = sum(half.P for half in halves)
    return [half.slope / P for half in halves]


def _projected(halves: Sequence[Contact]) -> tuple[Any, Any | None, Any]:
    """Return J, R and C of mortar and bonded contact."""
    shares = _relative_stiffness(halves)
    parts = [half.compliance(share) for half, share in zip(halves, shares, strict=True)]
    closure, slip = one_below_the_other([half.gap for half in halves]), None
    if halves[0].slip is not None:
        slip = one_below_the_other([half.slip for half in halves])
    compliance = block_diagonal(parts).convert("aij")
    destroy(*parts)
    return closure, slip, compliance


def _at_points(halves: Sequence[Contact]) -> tuple[Any, Any | None, Any]:
    """Return J, R and C of pointwise contact, compressed to the independent gaps."""
    gap, frictional = halves[0].gap, halves[0].slip is not None
    slips = [
        local_part(half.slip) if frictional else csr_array(local_part(half.gap).shape)
        for half in halves
    ]
    closure, reaction = few_forces(halves, slips)
    columns, comm = gap.getSizes()[1], gap.comm
    slip = distributed(reaction, columns, comm) if frictional else None
    return distributed(closure, columns, comm), slip, identity(closure.shape[0], comm)


def _body_stiffness(closure: Any, compliance: Any, stiffness: Floats) -> tuple[float, float]:
    """Return P (N/m) at which the stiffest and the softest force match the body stiffness."""
    squares, comm = of_entries(np.square, closure), closure.comm.tompi4py()
    relative = applied(squares, 1 / stiffness) / diagonal_of(compliance)
    destroy(squares)
    stiffest = comm.allreduce(relative.max(initial=0.0), MPI.MAX)
    felt = relative[relative > _UNFELT * stiffest]
    softest = comm.allreduce(felt.min(initial=stiffest), MPI.MIN)
    return 1 / stiffest, 1 / softest


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
