"""Stiffness and mass of a Lagrange space, assembled straight into the numbers of free unknowns.

PETSc passes over rows and columns of number -1: where supports hold plain components there is no
larger matrix from which a smaller one is cut. The stiffness couples all components, the mass each
with itself.

Element matrices are symmetric to the last bit, and an entry and its mirror image add the same
numbers in the same order. On several ranks the order of what comes from others is not known.
"""

from functools import cached_property
from typing import Any

import numpy as np

from cea.arrays import Floats, Ints
from cea.petsc import PETSc
from cea.supports.constraints import Constraints
from fe_cea.element_matrices import ElementMatrices
from fe_cea.quadrature import mass_degree, stiffness_degree
from fe_cea.sparsity import NodeGraph


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
        cells = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
        self._cells = V.dofmap.list[:cells]
        self._elements = ElementMatrices(V, self._cells)

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
        matrix = self._empty(held, coupled=True)
        component = np.arange(dim, dtype=np.int32)
        for cells in elements.chunks():
            dofs = dim * elements.dofs[cells, :, None] + component
            _add(matrix, dofs.reshape(len(dofs), -1), elements.stiffness(cells, rule, lame))
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
        matrix = self._empty(held, coupled=False)
        for cells in elements.chunks():
            masses = elements.mass(cells, rule, density)
            for component in range(dim):
                _add(matrix, dim * self._cells[cells] + component, masses)
        matrix.assemble()
        return matrix

    @cached_property
    def _graph(self) -> NodeGraph:
        return NodeGraph(self._space)

    def _empty(self, held: Constraints | None, *, coupled: bool) -> Any:
        numbers = self._every if held is None else held.numbers
        return self._graph.matrix(numbers, coupled=coupled)

    def _every(self, nodes: Ints) -> Ints:
        return self._dim * nodes[:, None] + np.arange(self._dim)


def _add(matrix: Any, dofs: Ints, values: Floats) -> None:
    """Add element matrices (cells, n, n) at local dofs (cells, n)."""
    matrix.setValuesLocalRCV(dofs, dofs, values, PETSc.InsertMode.ADD_VALUES)
