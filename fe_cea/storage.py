"""PETSc matrices whose entries are summed up in their final places.

What supports hold is left out: places are numbered by the unknowns that stay.
"""

from itertools import product
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.matrices import Rows, from_blocks
from cea.petsc import PETSc
from fe_cea.sparsity import Block, Indices, NodeGraph


class Unknowns:
    """Unknowns of the nodes of a graph.

    Parameters
    ----------
    numbers
        Number of each component of each node in the matrix, -1 where it is held; they rise with
        nodes and components, (nodes, dim).
    own
        Nodes of this rank, which come first.
    """

    def __init__(self, numbers: Ints, own: int) -> None:
        self.numbers = numbers
        self.own = own
        self.kept: NDArray[np.bool_] = numbers >= 0
        self.held: NDArray[np.bool_] = ~self.kept.all(axis=1)
        """Nodes of which a component is held."""
        self.counts: Ints = self.kept.sum(axis=1)
        """Unknowns of each node."""
        self.before: Ints = np.cumsum(self.kept, axis=1) - self.kept
        """Unknowns of the node ahead of each component, (nodes, dim)."""

    @property
    def dim(self) -> int:
        """Components of a node."""
        return self.numbers.shape[1]

    @property
    def first(self) -> int:
        """First of this rank, where it has any."""
        known = self.numbers[: self.own][self.kept[: self.own]]
        return int(known[0]) if len(known) else 0


class CoupledStorage:
    """Matrix in which all components of a node are coupled with all of those around it.

    Parameters
    ----------
    graph
        Entries.
    unknowns
        Unknowns of its nodes.
    """

    def __init__(self, graph: NodeGraph, unknowns: Unknowns) -> None:
        self._graph, self._unknowns = graph, unknowns
        dim = unknowns.dim
        own = unknowns.counts[: unknowns.own]
        first, width, self._sizes = [], [], [0]
        for block in (graph.inner, graph.outer):
            ends = np.append(0, np.cumsum(unknowns.counts[block.columns]))
            of_row = np.diff(ends[block.starts])
            starts = self._sizes[-1] + np.append(0, np.cumsum(own * of_row))
            first.append(np.repeat(starts[:-1] - ends[block.starts[:-1]], block.counts) + ends[:-1])
            width.append(np.repeat(of_row, block.counts))
            self._sizes.append(int(starts[-1]))
        sent = graph.num_entries - graph.size
        self._end = self._sizes[-1] + dim * dim * sent
        first.append(self._sizes[-1] + dim * dim * np.arange(sent))
        width.append(np.full(sent, dim))
        self._first, self._width = np.concatenate(first), np.concatenate(width)
        self._data = np.zeros(self._end + 1)  # the last place takes what is held

    def add(self, cells: slice, values: Floats) -> None:
        """Add element matrices of some cells, (cells, functions * dim, functions * dim)."""
        places, nodes = self._graph.places[cells], self._graph.cells[cells]
        first, width = self._first[places], self._width[places]
        count, n, _ = places.shape
        unknowns, dim = self._unknowns, self._unknowns.dim
        at = np.empty((count, n, dim, n * dim), dtype=np.intp)
        if unknowns.held[nodes].any():
            rows, columns = unknowns.before[nodes], unknowns.before[nodes][:, None, None]
            grid = first[:, :, None] + rows[:, :, :, None] * width[:, :, None]
            kept = unknowns.kept[nodes]
            stays = kept[:, :, :, None, None] & kept[:, None, None]
            found = np.where(stays, grid[..., None] + columns, self._end)
            at[:] = found.reshape(at.shape)
        else:
            at[:, :, 0] = (first[..., None] + np.arange(dim)).reshape(count, n, n * dim)
            step = np.repeat(width, dim, axis=2)
            for component in range(1, dim):
                np.add(at[:, :, component - 1], step, out=at[:, :, component])
        np.add.at(self._data, at.ravel(), values.ravel())

    def matrix(self) -> Any:
        """The matrix, PETSc AIJ, when all is added; collective."""
        start, end = self._sizes[-1], self._end
        sent = self._data[start:end].reshape(-1, self._unknowns.dim, self._unknowns.dim)
        self._graph.exchange.add(self._data, sent, self._grid)
        graph, middle = self._graph, len(self._graph.inner.columns)
        inner = self._csr(graph.inner, slice(*self._sizes[:2]), 0, self._unknowns.first)
        outer = self._csr(graph.outer, slice(*self._sizes[1:]), middle, 0)
        return from_blocks(inner, outer, graph.comm)

    def _grid(self, entries: Indices) -> Ints:
        """Places of the components of entries of this rank, (entries, dim, dim)."""
        counts, component = self._unknowns.counts, np.arange(self._unknowns.dim)
        ends = self._first[entries, None] + component * self._width[entries, None]
        rows, columns = self._graph.pairs(entries)
        in_rows, in_columns = component < counts[rows, None], component < counts[columns, None]
        there = in_rows[:, :, None] & in_columns[:, None]
        return np.where(there, ends[:, :, None] + component, self._end)

    def _csr(self, block: Block, part: slice, entry: int, first: int) -> Rows:
        """A block of which part of the data, first entry and first column are given."""
        unknowns, dim = self._unknowns, self._unknowns.dim
        every = slice(entry, entry + len(block.columns))
        at, width = self._first[every] - part.start, self._width[every]
        columns = np.empty(part.stop - part.start, dtype=PETSc.IntType)
        numbers = (unknowns.numbers - first).astype(PETSc.IntType)
        of_rows = np.repeat(unknowns.held[: unknowns.own], block.counts)
        whole = ~(of_rows | unknowns.held[block.columns])
        if whole.any():
            tuples = sliding_window_view(columns, dim, writeable=True)
            chosen: Any = slice(None) if whole.all() else whole
            place, step, found = at[chosen], width[chosen], numbers[block.columns[chosen]]
            for _ in range(dim):
                tuples[place] = found
                place = place + step
        some = np.flatnonzero(~whole)
        nodes, around = block.rows[some], block.columns[some]
        for row, column in product(range(dim), repeat=2):
            stays = unknowns.kept[nodes, row] & unknowns.kept[around, column]
            left, i, j = some[stays], nodes[stays], around[stays]
            place = at[left] + unknowns.before[i, row] * width[left] + unknowns.before[j, column]
            columns[place] = numbers[j, column]
        of_row = np.zeros(len(block.counts), dtype=np.int64)
        filled = block.counts > 0
        of_row[filled] = width[block.starts[:-1][filled]]
        lengths = np.repeat(of_row, unknowns.counts[: unknowns.own])
        return _starts(lengths), columns, self._data[part]


class ScalarStorage:
    """Matrix in which each component is coupled with itself, by the same numbers for all.

    Parameters
    ----------
    graph
        Entries.
    unknowns
        Unknowns of its nodes.
    """

    def __init__(self, graph: NodeGraph, unknowns: Unknowns) -> None:
        self._graph, self._unknowns = graph, unknowns
        self._data = np.zeros(graph.num_entries)

    def add(self, cells: slice, values: Floats) -> None:
        """Add scalar element matrices of some cells, (cells, functions, functions)."""
        np.add.at(self._data, self._graph.places[cells].ravel(), values.ravel())

    def matrix(self) -> Any:
        """The matrix, PETSc AIJ, when all is added; collective."""
        graph, size = self._graph, self._graph.size
        graph.exchange.add(self._data, self._data[size:])
        middle = len(graph.inner.columns)
        inner = self._csr(graph.inner, self._data[:middle], self._unknowns.first)
        outer = self._csr(graph.outer, self._data[middle:size], 0)
        return from_blocks(inner, outer, graph.comm)

    def _csr(self, block: Block, data: Floats, first: int) -> Rows:
        """A block of which the data and the first column are given."""
        unknowns, chosen = self._unknowns, list[Any]()
        lengths = np.empty((len(block.counts), unknowns.dim), dtype=np.int64)
        for component, kept in enumerate(unknowns.kept.T):
            if kept.all():
                chosen.append(slice(None))
                lengths[:, component] = block.counts
                continue
            stays = np.repeat(kept[: unknowns.own], block.counts) & kept[block.columns]
            chosen.append(stays)
            lengths[:, component] = np.diff(_starts(stays)[block.starts])
        starts = _starts(lengths.ravel())
        columns = np.empty(starts[-1], dtype=PETSc.IntType)
        values = np.empty(starts[-1])
        for component, here in enumerate(chosen):
            start, count = starts[component : -1 : unknowns.dim], lengths[:, component]
            place = np.repeat(start - (np.cumsum(count) - count), count)
            place += np.arange(len(place))
            numbers = (unknowns.numbers[:, component] - first).astype(PETSc.IntType)
            columns[place] = numbers[block.columns[here]]
            values[place] = data[here]
        return _starts(lengths[unknowns.kept[: unknowns.own]]), columns, values


def _starts(lengths: NDArray[Any]) -> Ints:
    """Where each of some rows begins, and where the last ends."""
    return np.append(0, np.cumsum(lengths))
