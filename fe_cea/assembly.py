"""Stiffness and mass of a Lagrange space, assembled straight into the numbers of free unknowns.

PETSc passes over rows and columns of number -1: where supports hold plain components there is no
larger matrix from which a smaller one is cut. The graph of the nodes is made once; it tells how
long the rows are of the stiffness, which couples all components, and of the mass, which couples
each with itself.

Element matrices are symmetric to the last bit, and an entry and its mirror image add the same
numbers in the same order. On several ranks the order of what comes from others is not known.
"""

from collections.abc import Iterator
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from cea.body import Floats, Ints
from cea.matrices import destroy, distributed
from cea.petsc import PETSc
from cea.supports.constraints import Constraints
from fe_cea.element_matrices import ElementMatrices
from fe_cea.quadrature import mass_degree, stiffness_degree


class _Graph(NamedTuple):
    """Nodes that share a cell with each node of this rank, by global numbers."""

    starts: Ints
    nodes: Ints


class Assembly:
    """Stiffness and mass of a Lagrange space, of all dofs or of those that supports leave free.

    Parameters
    ----------
    V
        Lagrange space (dolfinx), blocked with the dimension of its mesh.
    """

    def __init__(self, V: Any) -> None:
        self._space = V
        self._comm = V.mesh.comm
        self._dim = V.mesh.geometry.dim
        self._nodes = V.dofmap.index_map
        cells = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
        self._cells = V.dofmap.list[:cells]

    def stiffness(self, lame: tuple[float, float], held: Constraints | None = None) -> Any:
        """Elastic stiffness (N/m), PETSc AIJ, symmetric.

        Parameters
        ----------
        lame
            Lame parameters (lambda, mu) (N/m^2).
        held
            Supports that hold plain components, which the matrix is without; by default none.
        """
        elements, dim = self._elements, self._dim
        rule = elements.rule(stiffness_degree(self._space))
        numbers = self._numbers(self._local_nodes, held)
        matrix = self._empty(numbers, held, coupled=True)
        component = np.arange(dim, dtype=np.int32)[:, None]
        for cells in self._chunks(dim):
            dofs = (dim * self._cells[cells, None, :] + component).reshape(-1, dim * elements.size)
            _add(matrix, dofs, elements.stiffness(cells, rule, lame))
        matrix.assemble()
        return matrix

    def mass(
        self, density: float, held: Constraints | None = None, degree: int | None = None
    ) -> Any:
        """Consistent mass (kg), PETSc AIJ, symmetric; components are not coupled.

        Parameters
        ----------
        density
            Density (kg/m^3).
        held
            Supports that hold plain components, which the matrix is without; by default none.
        degree
            Degree of the quadrature, by default that which is exact on affine cells.
        """
        elements, dim = self._elements, self._dim
        rule = elements.rule(mass_degree(self._space) if degree is None else degree)
        numbers = self._numbers(self._local_nodes, held)
        matrix = self._empty(numbers, held, coupled=False)
        for cells in self._chunks(1):
            masses = elements.mass(cells, rule, density)
            for component in range(dim):
                _add(matrix, dim * self._cells[cells] + component, masses)
        matrix.assemble()
        return matrix

    @cached_property
    def _elements(self) -> ElementMatrices:
        return ElementMatrices(self._space)

    def _chunks(self, components: int) -> Iterator[slice]:
        count, step = len(self._cells), self._elements.chunk(components)
        return (slice(i, min(i + step, count)) for i in range(0, count, step))

    @property
    def _local_nodes(self) -> Ints:
        """Global numbers of the nodes this rank knows, its own first, (n,)."""
        count = self._nodes.size_local + self._nodes.num_ghosts
        return self._nodes.local_to_global(np.arange(count, dtype=np.int32)).astype(np.int64)

    def _numbers(self, nodes: Ints, held: Constraints | None) -> Ints:
        """Number of each component of nodes in the matrix, -1 where held, (n, dim)."""
        if held is not None:
            return held.numbers(nodes)
        return self._dim * nodes[:, None] + np.arange(self._dim)

    @cached_property
    def _graph(self) -> _Graph:
        own = (self._nodes.size_local, self._nodes.size_global)
        columns = self._nodes.local_to_global(self._cells.ravel())
        starts = np.arange(0, columns.size + 1, self._cells.shape[1])
        rows = csr_array((np.ones(columns.size), columns, starts), shape=(len(starts) - 1, own[1]))
        of_cells = distributed(rows, own, self._comm)
        graph = of_cells.transposeMatMult(of_cells)
        starts, nodes, _ = graph.getValuesCSR()
        destroy(of_cells, graph)
        return _Graph(starts, nodes)

    def _empty(self, numbers: Ints, held: Constraints | None, *, coupled: bool) -> Any:
        """AIJ matrix with room for the entries of its rows.

        Parameters
        ----------
        numbers
            Number of each component of the nodes this rank knows, -1 where held, (n, dim).
        held
            Supports that hold plain components.
        coupled
            Whether components are coupled with others.
        """
        first, last = self._nodes.local_range
        starts, nodes = self._graph
        near = (nodes >= first) & (nodes < last)
        own = numbers[: last - first] >= 0
        there = np.empty((self._dim, len(nodes)), dtype=bool)
        there[:, near] = own.T[:, nodes[near] - first]
        there[:, ~near] = self._numbers(nodes[~near], held).T >= 0
        sizes = []
        for which in (near, ~near):
            counts = np.add.reduceat(there & which, starts[:-1], axis=1, dtype=PETSc.IntType).T
            if coupled:
                counts = np.broadcast_to(counts.sum(axis=1, keepdims=True), own.shape)
            sizes.append(counts[own].astype(PETSc.IntType))
        layout = (len(sizes[0]), PETSc.DETERMINE)
        matrix = PETSc.Mat().createAIJ((layout, layout), nnz=tuple(sizes), comm=self._comm)
        table = PETSc.LGMap().create(numbers.astype(PETSc.IntType).ravel(), comm=self._comm)
        matrix.setLGMap(table, table)
        return matrix


def _add(matrix: Any, dofs: Ints, values: Floats) -> None:
    """Add element matrices (cells, n, n) at local dofs (cells, n)."""
    matrix.setValuesLocalRCV(dofs, dofs, values, PETSc.InsertMode.ADD_VALUES)
