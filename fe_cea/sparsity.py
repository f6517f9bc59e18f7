"""Sparsity of matrices on the free unknowns of nodes that share cells, made ahead of their values.

PETSc then finds the place of every value that is added, and never moves those that are there.
"""

from collections.abc import Callable
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cea.body import Ints
from cea.matrices import destroy, distributed
from cea.petsc import PETSc

Indices = NDArray[np.integer]
Numbers = Callable[[Ints], Ints]
"""Gives the number of each component of nodes in a matrix, -1 where it has none, (n, dim)."""

_CHUNK = 2**17
"""Entries written at a time: what it takes stays in the cache."""


class NodeGraph:
    """Nodes of a Lagrange space that share cells, those of this rank with all others.

    Parameters
    ----------
    V
        Lagrange space (dolfinx).
    """

    def __init__(self, V: Any) -> None:
        self._comm = V.mesh.comm
        self._nodes = V.dofmap.index_map
        cells = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
        self._cells = V.dofmap.list[:cells]

    def matrix(self, numbers: Numbers, *, coupled: bool) -> Any:
        """AIJ matrix of zeros, to which values are added by local numbers of components of nodes.

        Parameters
        ----------
        numbers
            Numbers of components of nodes, in which those of a node follow each other.
        coupled
            Whether all components of a node are coupled with all of another, or each with itself.
        """
        known = numbers(self._local_nodes)
        own = known[: self._nodes.size_local]
        rows = _sparsity(own, self._columns(known, numbers), self._graph[0], coupled=coupled)
        layout = (np.count_nonzero(own >= 0), PETSc.DETERMINE)
        matrix = PETSc.Mat().createAIJ((layout, layout), csr=rows, comm=self._comm)
        table = PETSc.LGMap().create(known.astype(PETSc.IntType).ravel(), comm=self._comm)
        matrix.setLGMap(table, table)
        table.destroy()
        return matrix

    @property
    def _local_nodes(self) -> Ints:
        """Global numbers of the nodes this rank knows, its own first, (n,)."""
        count = self._nodes.size_local + self._nodes.num_ghosts
        return self._nodes.local_to_global(np.arange(count, dtype=np.int32)).astype(np.int64)

    @cached_property
    def _graph(self) -> tuple[Indices, Indices]:
        """Neighbours of each node of this rank by rising global numbers: starts, and nodes."""
        own = (self._nodes.size_local, self._nodes.size_global)
        columns = self._nodes.local_to_global(self._cells.ravel())
        starts = np.arange(0, columns.size + 1, self._cells.shape[1])
        rows = csr_array((np.ones(columns.size), columns, starts), shape=(len(starts) - 1, own[1]))
        of_cells = distributed(rows, own, self._comm)
        graph = of_cells.transposeMatMult(of_cells)
        starts, nodes, _ = graph.getValuesCSR()
        destroy(of_cells, graph)
        return starts, nodes

    def _columns(self, known: Ints, numbers: Numbers) -> Indices:
        """Numbers of the components of all neighbours, (entries of the graph, dim)."""
        first, last = self._nodes.local_range
        nodes = self._graph[1]
        near = (nodes >= first) & (nodes < last)
        if near.all():
            return known.astype(PETSc.IntType)[nodes - first]
        columns = np.empty((len(nodes), known.shape[1]), dtype=PETSc.IntType)
        columns[near] = known[nodes[near] - first]
        columns[~near] = numbers(nodes[~near].astype(np.int64))
        return columns


def _sparsity(
    own: Ints, columns: Indices, starts: Indices, *, coupled: bool
) -> tuple[Indices, Indices]:
    """Rows of a matrix: starts, and columns.

    Parameters
    ----------
    own
        Numbers of the components of the nodes of this rank, (nodes, dim).
    columns
        Numbers of the components of their neighbours, (entries, dim).
    starts
        Start of each node's neighbours, (nodes + 1,).
    coupled
        Whether all components are coupled, or each with itself.
    """
    lists = [columns] if coupled else np.split(columns, columns.shape[1], axis=1)
    kept = [each >= 0 for each in lists]
    ends = [np.append(0, np.cumsum(keep.sum(axis=1)))[starts] for keep in kept]
    before = np.cumsum([0, *(end[-1] for end in ends[:-1])])
    begin = np.stack([end[:-1] + shift for end, shift in zip(ends, before, strict=True)], axis=1)
    length = np.stack([np.diff(end) for end in ends], axis=1)
    rows = own >= 0
    choices = np.concatenate([each[keep] for each, keep in zip(lists, kept, strict=True)])
    return _stretches(
        choices, np.broadcast_to(begin, own.shape)[rows], np.broadcast_to(length, own.shape)[rows]
    )


def _stretches(choices: Indices, begin: Ints, length: Ints) -> tuple[Indices, Indices]:
    """Stretches of an array one after the other: where each starts, and all of them."""
    starts = np.append(0, np.cumsum(length)).astype(PETSc.IntType)
    out = np.empty(starts[-1], dtype=choices.dtype)
    shift = (begin - starts[:-1]).astype(PETSc.IntType)
    chunks = np.searchsorted(starts, np.arange(0, len(out), _CHUNK))
    for first, last in pairwise(np.append(chunks, len(length))):
        place = np.arange(starts[first], starts[last], dtype=PETSc.IntType)
        place += np.repeat(shift[first:last], length[first:last])
        np.take(choices, place, out=out[starts[first] : starts[last]], mode="clip")
    return starts, out
