"""dolfinx as its demos use it, compiled for this machine: a vector stiffness and a scalar mass."""

from typing import Any

from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.matrices import local_part
from cea.petsc import MPI  # ahead of dolfinx
from comparisons.bench.programs.annulus import MATERIAL, Discretisation, rigid_motions

import basix.ufl  # isort: skip
import numpy as np  # isort: skip
import ufl  # isort: skip
from dolfinx.fem import form, functionspace  # isort: skip
from dolfinx.fem.petsc import assemble_matrix  # isort: skip
from dolfinx.mesh import create_mesh  # isort: skip

OPTIONS = {"cffi_extra_compile_args": ["-O3", "-march=native"]}


class PlainDolfinx:
    """Lagrange spaces of dolfinx, of vectors and of scalars."""

    vector_mass = False

    def __init__(self, discretisation: Discretisation) -> None:
        given, cell = discretisation.mesh(), discretisation.cell
        # Corners of both kinds of cell are listed with the last index fastest, basix has the first.
        order = [0, 4, 2, 6, 1, 5, 3, 7] if cell == "hexahedron" else [0, 1, 2, 3]
        element = basix.ufl.element("Lagrange", cell, 1, shape=(3,))
        mesh = create_mesh(MPI.COMM_SELF, given.cells[:, order], element, given.points)
        degree = discretisation.degree
        self._vectors = functionspace(mesh, ("Lagrange", degree, (3,)))
        self._of_mass = (
            self._vectors if self.vector_mass else functionspace(mesh, ("Lagrange", degree))
        )
        self._degrees = discretisation.stiffness_quadrature, discretisation.mass_quadrature

    def stiffness(self) -> Any:
        """PETSc AIJ."""
        u, v = ufl.TrialFunction(self._vectors), ufl.TestFunction(self._vectors)
        lam, mu = MATERIAL.lame
        strain = ufl.sym(ufl.grad(u))
        stress = lam * ufl.tr(strain) * ufl.Identity(3) + 2 * mu * strain
        return _assembled(ufl.inner(stress, ufl.sym(ufl.grad(v))), self._degrees[0])

    def mass(self) -> Any:
        """PETSc AIJ, of one component unless of vectors."""
        u, v = ufl.TrialFunction(self._of_mass), ufl.TestFunction(self._of_mass)
        return _assembled(MATERIAL.rho * ufl.inner(u, v), self._degrees[1])

    def compressed(self, matrix: Any) -> csr_array:
        """Rows of a matrix."""
        return local_part(matrix)

    def motions(self) -> Floats:
        """Rigid motions by nodes."""
        points: Floats = self._vectors.tabulate_dof_coordinates()
        return rigid_motions(np.asarray(points))


class MassOfVectors(PlainDolfinx):
    """Both matrices as forms of vectors."""

    vector_mass = True


def _assembled(integrand: Any, degree: int) -> Any:
    dx = ufl.dx(metadata={"quadrature_degree": degree})
    matrix = assemble_matrix(form(integrand * dx, jit_options=dict(OPTIONS)))
    matrix.assemble()
    return matrix
