"""NGSolve."""

from typing import Any

import netgen.meshing as netgen
import ngsolve as ng
import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from comparisons.bench.programs.annulus import AROUND, MATERIAL, Discretisation


class NGSolve:
    """A space of vectors."""

    def __init__(self, discretisation: Discretisation) -> None:
        ng.SetNumThreads(1)
        given = discretisation.mesh()
        mesh = netgen.Mesh(dim=3)
        points = [mesh.Add(netgen.MeshPoint(netgen.Pnt(*point))) for point in given.points]
        box = discretisation.family == "Q"
        cells = given.cells[:, AROUND] if box else given.cells
        for cell in cells.tolist():
            mesh.Add(netgen.Element3D(1, [points[node] for node in cell]))
        self._kind = ng.ET.HEX if box else ng.ET.TET
        self._space = ng.VectorH1(ng.Mesh(mesh), order=discretisation.degree)
        self._degrees = discretisation.stiffness_quadrature, discretisation.mass_quadrature

    def _dx(self, degree: int) -> Any:
        return ng.dx(intrules={self._kind: ng.IntegrationRule(self._kind, degree)})

    def _assembled(self, integrand: Any, degree: int) -> Any:
        form = ng.BilinearForm(self._space, symmetric=False)
        form += integrand * self._dx(degree)
        form.Assemble()
        return form

    def stiffness(self) -> Any:
        """The form that holds the matrix."""
        u, v = self._space.TnT()
        lam, mu = MATERIAL.lame
        strain = 0.5 * (ng.Grad(u) + ng.Grad(u).trans)
        other = 0.5 * (ng.Grad(v) + ng.Grad(v).trans)
        stress = lam * ng.Trace(strain) * ng.Id(3) + 2 * mu * strain
        return self._assembled(ng.InnerProduct(stress, other), self._degrees[0])

    def mass(self) -> Any:
        """The form that holds the matrix."""
        u, v = self._space.TnT()
        return self._assembled(MATERIAL.rho * ng.InnerProduct(u, v), self._degrees[1])

    def compressed(self, matrix: Any) -> csr_array:
        """Rows of a matrix."""
        values, columns, starts = matrix.mat.CSR()
        size = matrix.mat.height
        return csr_array((np.array(values), np.array(columns), np.array(starts)), (size, size))

    def motions(self) -> Floats:
        """Rigid motions by its interpolation, which is exact."""
        x, y, z = ng.x, ng.y, ng.z
        fields = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -z, y), (z, 0, -x), (-y, x, 0)]
        found = []
        for field in fields:
            function = ng.GridFunction(self._space)
            function.Set(ng.CoefficientFunction(field))
            found.append(function.vec.FV().NumPy().copy())
        return np.column_stack(found)
