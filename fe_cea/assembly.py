"""Stiffness and mass of a Lagrange space, assembled straight into the numbers of free unknowns.

Where supports hold plain components there is no larger matrix from which a smaller one is cut. The
stiffness couples all components, the mass each with itself.

Element matrices are symmetric to the last bit, and an entry and its mirror image add the same
numbers in the same order, on any number of ranks.
"""

from functools import cached_property
from typing import Any

import numpy as np

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
    """

    def __init__(self, V: Any) -> None:
        self._space = V
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
        return NodeGraph(self._space)

    @cached_property
    def _elements(self) -> ElementMatrices:
        return ElementMatrices(self._space, len(self._graph.cells))

    def _unknowns(self, held: Constraints | None) -> Unknowns:
        nodes = self._graph.nodes
        every = self._dim * nodes[:, None] + np.arange(self._dim)
        return Unknowns(every if held is None else held.numbers(nodes), self._graph.own)
