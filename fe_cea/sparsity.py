"""Room for matrices on the free unknowns of nodes that share cells, made ahead of their values."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cea.arrays import Ints
from cea.matrices import destroy, distributed
from cea.petsc import PETSc
from fe_cea.distribution import lasting_communicator

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
        self._comm = lasting_communicator(V.mesh.comm)
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
        room: Any = tuple(
            np.broadcast_to(counts.sum(axis=1, keepdims=True) if coupled else counts, own.shape)[
                own
            ].astype(PETSc.IntType)
            for counts in self._neighbours(own, numbers)
        )
        layout = (int(np.count_nonzero(own)), PETSc.DETERMINE)
        matrix = PETSc.Mat().createAIJ((layout, layout), nnz=room, comm=self._comm)
        # Said on every rank: ranks without rows give no room, and would look for new entries alone.
        no_more: Any = PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR
        matrix.setOption(no_more, True)
        places: Any = known.astype(PETSc.IntType).ravel()
        table = PETSc.LGMap().create(places, comm=self._comm)
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
        """Neighbours of each node of this rank by global numbers: starts, and nodes."""
        own = (self._nodes.size_local, self._nodes.size_global)
        columns = self._nodes.local_to_global(self._cells.ravel())
        starts = np.arange(0, columns.size + 1, self._cells.shape[1])
        rows = csr_array((np.ones(columns.size), columns, starts), shape=(len(starts) - 1, own[1]))
        if self._comm.size == 1:  # many times faster than PETSc's product
            local = rows.T.tocsr() @ rows
            return local.indptr, local.indices
        of_cells = distributed(rows, own, self._comm)
        graph = of_cells.transposeMatMult(of_cells)
        starts, nodes, _ = graph.getValuesCSR()
        destroy(of_cells, graph)
        return starts, nodes

    def _neighbours(self, own: Truths, numbers: Numbers) -> tuple[Ints, Ints]:
        """How many neighbours of each node have each component, on this rank and on others.

        Parameters
        ----------
        own
            Which components the nodes of this rank have, (nodes, dim).
        numbers
            Numbers of components of nodes.

        Returns
        -------
        tuple of ndarray
            Each of shape (nodes, dim).
        """
        first, last = self._nodes.local_range
        starts, nodes = self._graph
        far = np.flatnonzero((nodes < first) | (nodes >= last))
        of_others = _counts(starts, far, numbers(nodes[far].astype(np.int64)) >= 0)
        here = np.diff(starts)[:, None] - _counts(starts, far, np.ones((len(far), own.shape[1])))
        held = ~own.all(axis=1)
        if held.any():  # a few near the supports
            near = nodes - first
            near[far] = 0
            some = np.setdiff1d(np.flatnonzero(held[near]), far, assume_unique=True)
            here -= _counts(starts, some, ~own[near[some]])
        return here, of_others


def _counts(starts: Indices, entries: Indices, true: Any) -> Ints:
    """How often some entries of rows are true, (rows, columns); true (entries, columns)."""
    row = np.searchsorted(starts, entries, side="right") - 1
    columns = [np.bincount(row, weights=each, minlength=len(starts) - 1) for each in true.T]
    return np.stack(columns, axis=1).astype(np.int64)
