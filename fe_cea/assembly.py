"""Stiffness and mass of a Lagrange space, assembled straight into the numbers of free unknowns.

Where supports hold plain components there is no larger matrix from which a smaller one is cut. The
stiffness couples all components, the mass each with itself.

Element matrices are symmetric to the last bit, and an entry and its mirror image add the same
numbers in the same order, on any number of ranks.
"""

from functools import cached_property
from typing import Any

import numpy as np
from dolfinx import la
from numpy.typing import NDArray

from cea.arrays import Ints
from cea.supports.constraints import Constraints
from fe_cea.element_matrices import ElementMatrices
from fe_cea.quadrature import mass_degree, stiffness_degree
from fe_cea.sparsity import NodeGraph
from fe_cea.storage import CoupledStorage, ScalarStorage, Unknowns


class Assembly:
    """Stiffness and mass of a Lagrange space, of all dofs or of those that supports leave free.

    Parameters
    ----------
    V
        Lagrange space (dolfinx), blocked with the dimension of its mesh.
    cells
        Cells of this rank that are integrated over; by default all of them.
    """

    def __init__(self, V: Any, cells: Ints | None = None) -> None:
        self._space, self._cells = V, cells
        self._dim = V.mesh.geometry.dim

    def stiffness(self, lame: tuple[float, float], held: Constraints | None = None) -> Any:
        """Elastic stiffness (N/m), PETSc AIJ, symmetric.

        Parameters
        ----------
        lame
            Lame parameters (lambda, mu) (N/m^2).
        held
            Supports that hold plain components, which the matrix is without; by default none.
        """
        elements = self._elements
        rule = elements.rule(stiffness_degree(self._space))
        storage = CoupledStorage(self._graph, self._unknowns(held))
        for cells in elements.chunks():
            storage.add(cells, elements.stiffness(cells, rule, lame))
        return storage.matrix()

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
        elements = self._elements
        rule = elements.rule(mass_degree(self._space) if degree is None else degree)
        storage = ScalarStorage(self._graph, self._unknowns(held))
        for cells in elements.chunks():
            storage.add(cells, elements.mass(cells, rule, density))
        return storage.matrix()

    @cached_property
    def _graph(self) -> NodeGraph:
        return NodeGraph(self._space, self._cells)

    @cached_property
    def _elements(self) -> ElementMatrices:
        mesh = self._space.mesh
        count = mesh.topology.index_map(mesh.topology.dim).size_local
        return ElementMatrices(self._space, count, self._cells)

    def _unknowns(self, held: Constraints | None) -> Unknowns:
        nodes = self._graph.nodes
        every = self._dim * nodes[:, None] + np.arange(self._dim)
        return Unknowns(every if held is None else held.numbers(nodes), self._graph.own)


def cells_within(V: Any, nodes: NDArray[np.bool_]) -> Ints:
    """Cells of this rank all of whose nodes are among some; collective.

    Parameters
    ----------
    V
        Lagrange space (dolfinx).
    nodes
        Whether each node of this rank is among them, shape (n_local,).
    """
    among = la.vector(V.dofmap.index_map, dtype=np.int8)
    among.array[: len(nodes)] = nodes
    among.scatter_forward()
    mesh = V.mesh
    count = mesh.topology.index_map(mesh.topology.dim).size_local
    return np.flatnonzero(among.array[V.dofmap.list[:count]].all(axis=1))
