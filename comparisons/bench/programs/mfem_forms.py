"""MFEM, through its Python package."""

from typing import Any

import mfem.ser as mfem
import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from comparisons.bench.programs.annulus import AROUND, MATERIAL, Discretisation, rigid_motions


class Mfem:
    """A space of vectors, their components beside each other."""

    def __init__(self, discretisation: Discretisation) -> None:
        given = discretisation.mesh()
        box = discretisation.family == "Q"
        mesh = mfem.Mesh(3, len(given.points), len(given.cells))
        for point in given.points.tolist():
            mesh.AddVertex(*point)
        order = AROUND if box else (0, 2, 1, 3)  # of the other hand than those of cea.mesh.Mesh
        for cell in given.cells[:, order].tolist():
            (mesh.AddHex if box else mesh.AddTet)(*cell)
        if box:
            mesh.FinalizeHexMesh(1, 0, False)
        else:
            mesh.FinalizeTetMesh(1, 0, False)
        self._mesh = mesh
        self._collection = mfem.H1_FECollection(discretisation.degree, 3)
        space = mfem.FiniteElementSpace(mesh, self._collection, 3, mfem.Ordering.byVDIM)
        self._space = space
        kind = mfem.Geometry.CUBE if box else mfem.Geometry.TETRAHEDRON
        degrees = discretisation.stiffness_quadrature, discretisation.mass_quadrature
        self._rules = [mfem.IntRules.Get(kind, degree) for degree in degrees]
        numbers = (*MATERIAL.lame, MATERIAL.rho)
        self._numbers = [mfem.ConstantCoefficient(number) for number in numbers]

    def _assembled(self, integrator: Any, rule: Any) -> Any:
        integrator.SetIntRule(rule)
        form = mfem.BilinearForm(self._space)
        form.AddDomainIntegrator(integrator)
        integrator.thisown = False  # the form ends it
        form.Assemble()
        form.Finalize()
        return form

    def stiffness(self) -> Any:
        """The form that holds the matrix."""
        lam, mu, _ = self._numbers
        return self._assembled(mfem.ElasticityIntegrator(lam, mu), self._rules[0])

    def mass(self) -> Any:
        """The form that holds the matrix."""
        return self._assembled(mfem.VectorMassIntegrator(self._numbers[2]), self._rules[1])

    def compressed(self, matrix: Any) -> csr_array:
        """Rows of a matrix."""
        rows = matrix.SpMat()
        size = rows.Height()
        arrays = (rows.GetDataArray(), rows.GetJArray(), rows.GetIArray())
        data, columns, starts = (np.array(array) for array in arrays)
        return csr_array((data, columns, starts), (size, size))

    def motions(self) -> Floats:
        """Rigid motions by nodes."""
        nodes = mfem.GridFunction(self._space)
        self._mesh.GetNodes(nodes)
        return rigid_motions(np.array(nodes.GetDataArray()).reshape(-1, 3))
