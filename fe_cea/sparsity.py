"""Room for matrices on the free unknowns of nodes that share cells, made ahead of their values."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cea.body import Ints
from cea.matrices import destroy, distributed
from cea.petsc import PETSc

Indices = NDArray[np.integer]
Truths = NDArray[np.bool_]
Numbers = Callable[[Ints], Ints]
"""Gives the number of each component of nodes in a matrix, -1 where it has none, (n, dim)."""


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
        """Empty AIJ matrix, to which values are added by local numbers of components of nodes.

        Parameters
        ----------
        numbers
            Numbers of components of nodes, which rise with both.
        coupled
            Whether all components of a node are coupled with all of another, or each with itself.
        """
        known = numbers(self._local_nodes)
        own = known[: self._nodes.size_local] >= 0
        near, there = self._neighbours(own, numbers)
        sizes = []
        for which in (near, ~near):
            counts = _sums(there & which[:, None], self._graph[0])
            if coupled:
                counts = np.broadcast_to(counts.sum(axis=1, keepdims=True), own.shape)
            sizes.append(counts[own].astype(PETSc.IntType))
        layout = (np.count_nonzero(own), PETSc.DETERMINE)
        matrix = PETSc.Mat().createAIJ((layout, layout), nnz=tuple(sizes), comm=self._comm)
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

    def _neighbours(self, own: Truths, numbers: Numbers) -> tuple[Truths, Truths]:
        """Of each neighbour: whether it is of this rank, (n,); which components it has, (n, dim).

        Parameters
        ----------
        own
            Which components the nodes of this rank have, (nodes, dim).
        numbers
            Numbers of components of nodes.
        """
        first, last = self._nodes.local_range
        nodes = self._graph[1]
        near = (nodes >= first) & (nodes < last)
        if near.all():
            return near, own[nodes - first]
        there = np.empty((len(nodes), own.shape[1]), dtype=bool)
        there[near] = own[nodes[near] - first]
        there[~near] = numbers(nodes[~near].astype(np.int64)) >= 0
        return near, there


def _sums(rows: Truths, starts: Indices) -> Ints:
    """Numbers of true entries in stretches of rows that follow each other, (stretches, columns)."""
    before = np.zeros((rows.shape[1], len(rows) + 1), dtype=np.int64)
    np.cumsum(rows.T, axis=1, out=before[:, 1:])
    return np.diff(before[:, starts], axis=1).T
