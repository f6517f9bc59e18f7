"""scikit-fem."""

from typing import Any

import numpy as np
import skfem
from scipy.sparse import csr_array
from skfem.helpers import ddot, dot, eye, sym_grad, trace

from cea.arrays import Floats
from comparisons.bench.programs.annulus import MATERIAL, Discretisation, rigid_motions

_CORNERS = [0, 1, 2, 4, 3, 5, 6, 7]
"""Corners of its hexahedron among those of :class:`cea.mesh.Mesh`."""
_ELEMENTS = {
    ("Q", 1): skfem.ElementHex1,
    ("Q", 2): skfem.ElementHex2,
    ("P", 1): skfem.ElementTetP1,
    ("P", 2): skfem.ElementTetP2,
}


class ScikitFem:
    """A basis for each matrix, as each has its own quadrature."""

    def __init__(self, discretisation: Discretisation) -> None:
        given = discretisation.mesh()
        if discretisation.family == "Q":
            mesh = skfem.MeshHex(given.points.T, given.cells[:, _CORNERS].T)
        else:
            mesh = skfem.MeshTet(given.points.T, given.cells.T)
        element = _ELEMENTS[discretisation.family, discretisation.degree]()
        self._mesh, self._element = mesh, skfem.ElementVector(element)
        self._degrees = discretisation.stiffness_quadrature, discretisation.mass_quadrature

    def _basis(self, degree: int) -> Any:
        return skfem.Basis(self._mesh, self._element, intorder=degree)

    def stiffness(self) -> Any:
        """Scipy CSR."""
        lam, mu = MATERIAL.lame

        @skfem.BilinearForm
        def form(u: Any, v: Any, _: Any) -> Any:
            strain = sym_grad(u)
            stress = lam * eye(trace(strain), 3) + 2 * mu * strain
            return ddot(stress, sym_grad(v))

        return form.assemble(self._basis(self._degrees[0]))

    def mass(self) -> Any:
        """Scipy CSR."""

        @skfem.BilinearForm
        def form(u: Any, v: Any, _: Any) -> Any:
            return MATERIAL.rho * dot(u, v)

        return form.assemble(self._basis(self._degrees[1]))

    def compressed(self, matrix: Any) -> csr_array:
        """A matrix as it is."""
        return csr_array(matrix)

    def motions(self) -> Floats:
        """Rigid motions by projection, which is exact."""
        basis = self._basis(self._degrees[1])

        def motion(i: int) -> Any:
            def at(x: Floats) -> Floats:
                return rigid_motions(x.reshape(3, -1).T)[:, i].reshape(-1, 3).T.reshape(x.shape)

            return at

        return np.column_stack([basis.project(motion(i)) for i in range(6)])
