"""Which nodes of a Lagrange space share cells, and where each pair of a cell is kept.

A pair of nodes is an entry. Entries are numbered row by row: first those of nodes of this rank with
one another, then those of its nodes with nodes of others, last those of rows of other ranks to
which cells of this rank add. The first two are the blocks that PETSc keeps apart.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, csr_matrix

from cea.arrays import Ints
from fe_cea.distribution import lasting_communicator
from fe_cea.exchange import Exchange

Indices = NDArray[np.integer[Any]]


@dataclass(frozen=True)
class Block:
    """Rows of entries.

    Parameters
    ----------
    starts
        First entry of each row, and the end of the last, (rows + 1,).
    columns
        Node of each entry, by its number in :class:`NodeGraph`.
    """

    starts: Indices
    columns: Indices

    @property
    def counts(self) -> Indices:
        """Entries of each row."""
        return np.diff(self.starts)

    @property
    def rows(self) -> Ints:
        """Row of each entry."""
        return np.repeat(np.arange(len(self.starts) - 1), self.counts)


class NodeGraph:
    """Entries of the matrices of a Lagrange space on this rank; made collectively.

    Nodes are numbered anew: first those of this rank as the space has them, then by rising global
    number those of others that share a cell with them or are of a cell of this rank.

    Parameters
    ----------
    V
        Lagrange space (dolfinx).
    chosen
        Cells of this rank whose pairs are entries; by default all of them.
    """

    def __init__(self, V: Any, chosen: Ints | None = None) -> None:
        self.comm = lasting_communicator(V.mesh.comm)
        nodes = V.dofmap.index_map
        self.own = int(nodes.size_local)
        """Nodes of this rank."""
        self._first = int(nodes.local_range[0])
        count = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
        cells = V.dofmap.list[:count]
        if chosen is not None:
            cells = cells[chosen]
        ghosts = np.asarray(nodes.ghosts, dtype=np.int64)
        rising = np.arange(self.own + len(ghosts), dtype=np.int32)
        rising[self.own + np.argsort(ghosts)] = rising[self.own :].copy()
        cells = rising[cells]
        here = _sharing(cells, len(rising))
        entries = self._settled(here, np.sort(ghosts))
        self.places = _at(here, entries, cells[:, :, None], cells[:, None])
        """Entry of each pair of nodes of each cell, (cells, functions, functions)."""
        self.cells = np.searchsorted(self._others, np.sort(ghosts)).astype(np.int32)
        self.cells = np.append(rising[: self.own], self.own + self.cells)[cells]
        """Nodes of each cell, (cells, functions)."""

    @property
    def size(self) -> int:
        """Entries of the rows of this rank."""
        return len(self.inner.columns) + len(self.outer.columns)

    def pairs(self, entries: Indices) -> tuple[Ints, Indices]:
        """Nodes of the row and of the column of entries of rows of this rank."""
        rows = np.concatenate([self.inner.rows, self.outer.rows])
        return rows[entries], np.concatenate([self.inner.columns, self.outer.columns])[entries]

    @property
    def nodes(self) -> Ints:
        """Global number of each node."""
        return np.append(self._first + np.arange(self.own), self._others)

    def _settled(self, here: csr_array, ghosts: Ints) -> Indices:
        """Settle with other ranks what entries there are.

        Parameters
        ----------
        here
            Which nodes share cells of this rank; those of other ranks come last.
        ghosts
            Global numbers of those of other ranks, rising.

        Returns
        -------
        ndarray
            Entry of each nonzero of ``here``.
        """
        own, comm = self.own, self.comm
        self._others = ghosts
        if comm.size == 1:
            self.inner, self.outer = _block(here), _block(csr_array((own, 0)))
            self.exchange = Exchange(comm, [slice(0, 0)], [here.indices[:0]])
            self.num_entries = int(here.nnz)
            return np.arange(here.nnz, dtype=np.int32)
        cuts = own + np.append(np.searchsorted(ghosts, comm.allgather(self._first)), len(ghosts))
        cuts[0] = own
        end = here.indptr[own]
        parts = [slice(*here.indptr[cuts[rank : rank + 2]] - end) for rank in range(comm.size)]
        known = self.nodes
        rows = np.repeat(known[own:], np.diff(here.indptr[own:]))
        columns = known[here.indices[end:]]
        told = comm.alltoall([(rows[part], columns[part]) for part in parts])

        came = np.concatenate([pairs[1] for pairs in told])
        far = came[(came < self._first) | (came >= self._first + own)]
        self._others = np.union1d(ghosts, far)
        received = [(r - self._first, self._number(c)) for r, c in told]
        shape = (own, own + len(self._others))
        columns = self._number(known).astype(np.int32)[here.indices[:end]]
        starts = here.indptr[: own + 1]
        mine, fresh = _with_more(csr_array((columns, columns, starts), shape), received)

        far = mine.indices >= own
        beyond = np.zeros(mine.nnz + 1, dtype=np.int32)
        np.cumsum(far, out=beyond[1:])
        number = np.arange(mine.nnz, dtype=np.int32)
        number -= beyond[:-1]
        number[far] = np.arange(mine.nnz - beyond[-1], mine.nnz)
        outer_starts = beyond[mine.indptr]
        self.inner = Block(mine.indptr - outer_starts, mine.indices[~far])
        self.outer = Block(outer_starts, mine.indices[far])
        taken = [_at(mine, number, *pair) for pair in received]
        self.exchange = Exchange(comm, parts, taken)
        self.num_entries = int(mine.nnz + here.nnz - end)
        places = np.arange(mine.nnz - end, self.num_entries, dtype=np.int32)
        places[:end] = np.delete(number, fresh)
        return places

    def _number(self, nodes: Ints) -> Ints:
        """Number of nodes by their global numbers."""
        own = (nodes >= self._first) & (nodes < self._first + self.own)
        return np.where(own, nodes - self._first, self.own + np.searchsorted(self._others, nodes))


def _sharing(cells: Indices, count: int) -> csr_array:
    """Which of so many nodes share cells, those of each row rising."""
    starts = np.arange(0, cells.size + 1, cells.shape[1], dtype=np.int32)
    ones = np.ones(cells.size, dtype=np.int32)
    nodes = csr_array((ones, cells.ravel(), starts), shape=(len(cells), count))
    return _sorted(nodes.T.tocsr() @ nodes)


def _with_more(mine: csr_array, received: list[tuple[Ints, Ints]]) -> tuple[csr_array, Indices]:
    """A pattern with the entries that other ranks tell of, too.

    Parameters
    ----------
    mine
        Entries that are known, rising in each row.
    received
        Rows and columns that each rank tells of.

    Returns
    -------
    tuple
        The pattern, rising in each row, and where in it those are that were not known.
    """
    width = mine.shape[1]
    told = np.unique(np.concatenate([row * width + column for row, column in received]))
    # Few rows are told of: only those are looked at.
    rows = np.unique(told // width)
    lengths = np.diff(mine.indptr)
    within = csr_array(mine[rows])
    known = np.repeat(rows, np.diff(within.indptr)) * width + within.indices
    place = np.searchsorted(known, told)
    fresh = np.append(known, -1)[place] != told
    row, column = np.divmod(told[fresh], width)
    at = place[fresh] + (mine.indptr[rows] - within.indptr[:-1])[np.searchsorted(rows, row)]
    indices = np.insert(mine.indices, at, column.astype(mine.indices.dtype))
    starts = _starts(lengths + np.bincount(row, minlength=len(lengths)))
    pattern = csr_array((indices, indices, starts), shape=mine.shape)
    return pattern, at + np.arange(len(at))


def _starts(lengths: Ints) -> Indices:
    """Where rows of some lengths start, and where the last ends."""
    return np.append(0, np.cumsum(lengths)).astype(np.int32)


def _sorted(matrix: csr_array) -> csr_array:
    """The same with the columns of each row rising."""
    matrix.has_sorted_indices = False
    matrix.sort_indices()
    return matrix


def _block(rows: csr_array) -> Block:
    return Block(rows.indptr, rows.indices)


def _at(pattern: csr_array, values: Indices, rows: Any, columns: Any) -> Indices:
    """Values that go with the nonzeros of a pattern at some rows and columns."""
    table = csr_matrix((values, pattern.indices, pattern.indptr), shape=pattern.shape)
    table.has_canonical_format = True
    rows, columns = np.broadcast_arrays(rows, columns)
    if rows.size == 0:
        return np.zeros(rows.shape, dtype=values.dtype)
    found: Indices = np.asarray(table[rows.ravel(), columns.ravel()])
    return found.reshape(rows.shape)
