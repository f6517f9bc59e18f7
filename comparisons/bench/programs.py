"""A quarter of a thick ring, divided alike by every program, and the programs that assemble it.

Lagrange cells have straight edges, their corners on the ring; NURBS represent the ring exactly.
"""

from dataclasses import dataclass
from math import pi
from typing import Any, Literal

import numpy as np
from scipy.sparse import csc_array, csr_array, eye_array, kron
from scipy.sparse.linalg import eigsh, spsolve

from cea.arrays import Floats
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.matrices import local_part
from cea.mesh import Mesh
from cea.petsc import MPI  # ahead of dolfinx
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Sector
from scenes.building.build import build_body
from scenes.spec.body import BodySpec, FeMesh, IgaMesh, MeshSpec

import basix.ufl  # isort: skip
import ufl  # isort: skip
from dolfinx.fem import form, functionspace  # isort: skip
from dolfinx.fem.petsc import assemble_matrix  # isort: skip
from dolfinx.mesh import create_mesh  # isort: skip

Family = Literal["NURBS", "Q", "P"]
"""NURBS of highest continuity, Lagrange hexahedra, Lagrange tetrahedra."""
Boxes = tuple[int, int, int]
"""Elements along radius, angle and height; tetrahedra are such boxes divided into six."""

RING = Sector(1.0, 2.0, 0.0, 90.0, 0.0, 0.5)
MATERIAL = IsotropicMaterial(E=1.0, nu=0.3, rho=1.0)
EXACT_VOLUME = pi / 4 * (2.0**2 - 1.0**2) * 0.5
"""Volume of the ring itself (m^3); that of cells with straight edges is smaller."""
_WEDGES = 6
"""Tetrahedra that a box is divided into."""
_OPTIONS = {"cffi_extra_compile_args": ["-O3", "-march=native"]}
_RIGID = 6
"""Rigid motions in space."""
_BELOW = 1e-3
"""Shift below zero, as part of the smallest ratio of diagonals: K of a free body is singular."""


@dataclass(frozen=True)
class Discretisation:
    """Functions and elements that the body is divided into."""

    family: Family
    degree: int
    boxes: Boxes

    def __post_init__(self) -> None:
        if min(self.boxes) < 1:
            raise InputError("boxes", self.boxes, "one or more along each direction")

    @property
    def elements(self) -> int:
        """Number of elements."""
        r, theta, z = self.boxes
        return r * theta * z * (_WEDGES if self.family == "P" else 1)

    @property
    def quadrature(self) -> tuple[int, int]:
        """Degrees to which stiffness and mass are integrated, exact on affine cells."""
        return 2 * (self.degree - 1) if self.family == "P" else 2 * self.degree, 2 * self.degree

    @property
    def cell(self) -> Literal["hexahedron", "tetrahedron"]:
        """Kind of its Lagrange cells."""
        return "tetrahedron" if self.family == "P" else "hexahedron"

    def mesh(self) -> Mesh:
        """Lagrange cells with straight edges."""
        return shape_mesh(RING, self.cell, 1, breaks=breaks_of(RING, self.boxes, {}))


class Ours:
    """A body of this program without supports: its space is made, its matrices are not."""

    def __init__(self, discretisation: Discretisation) -> None:
        degree, boxes = discretisation.degree, discretisation.boxes
        if discretisation.family == "NURBS":
            spec = BodySpec("iga", RING, MATERIAL, MeshSpec(iga=IgaMesh((degree,) * 3, boxes)))
        else:
            mesh = FeMesh(discretisation.cell, degree, geometry_degree=1, elements=boxes)
            spec = BodySpec("fe", RING, MATERIAL, MeshSpec(fe=mesh))
        self._body = build_body("ring", spec)

    def stiffness(self) -> Any:
        """PETSc AIJ, made anew."""
        return self._body.stiffness()

    def mass(self) -> Any:
        """PETSc AIJ, made anew."""
        return self._body.mass()

    def motions(self) -> Floats:
        """Coefficients of the rigid motions."""
        cells = self._body.volume_cells()
        # Positions are a field of the space: those coefficients that give it at the points.
        values = csc_array(cells.values)
        return rigid_motions(spsolve(values.T @ values, values.T @ cells.points))


class PlainDolfinx:
    """dolfinx as its demos use it, for this machine: a vector stiffness and a scalar mass."""

    vector_mass = False

    def __init__(self, discretisation: Discretisation) -> None:
        given, cell = discretisation.mesh(), discretisation.cell
        # Corners of both kinds of cell are listed with the last index fastest, basix has the first.
        order = [0, 4, 2, 6, 1, 5, 3, 7] if cell == "hexahedron" else [0, 1, 2, 3]
        element = basix.ufl.element("Lagrange", cell, 1, shape=(3,))
        mesh = create_mesh(MPI.COMM_SELF, given.cells[:, order], element, given.points)
        self._vectors = functionspace(mesh, ("Lagrange", discretisation.degree, (3,)))
        scalars = functionspace(mesh, ("Lagrange", discretisation.degree))
        self._of_mass = self._vectors if self.vector_mass else scalars
        self._degrees = discretisation.quadrature

    def stiffness(self) -> Any:
        """PETSc AIJ, made anew."""
        u, v = ufl.TrialFunction(self._vectors), ufl.TestFunction(self._vectors)
        lam, mu = MATERIAL.lame
        strain = ufl.sym(ufl.grad(u))
        stress = lam * ufl.tr(strain) * ufl.Identity(3) + 2 * mu * strain
        return _assembled(ufl.inner(stress, ufl.sym(ufl.grad(v))), self._degrees[0])

    def mass(self) -> Any:
        """PETSc AIJ, made anew, of one component unless of vectors."""
        u, v = ufl.TrialFunction(self._of_mass), ufl.TestFunction(self._of_mass)
        return _assembled(MATERIAL.rho * ufl.inner(u, v), self._degrees[1])

    def motions(self) -> Floats:
        """Coefficients of the rigid motions."""
        return rigid_motions(np.asarray(self._vectors.tabulate_dof_coordinates()))


class MassOfVectors(PlainDolfinx):
    """dolfinx with both matrices as forms of vectors."""

    vector_mass = True


def _assembled(integrand: Any, degree: int) -> Any:
    dx = ufl.dx(metadata={"quadrature_degree": degree})
    matrix = assemble_matrix(form(integrand * dx, jit_options=dict(_OPTIONS)))
    matrix.assemble()
    return matrix


def rigid_motions(points: Floats) -> Floats:
    """Three translations and three rotations about the axes, components after each other by point.

    Parameters
    ----------
    points
        The points, shape (n, 3).

    Returns
    -------
    ndarray
        Shape (3 n, 6).
    """
    motions = np.zeros((len(points), 3, 6))
    motions[:, [0, 1, 2], [0, 1, 2]] = 1.0
    x, y, z = points.T
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 2, 4], motions[:, 0, 4] = -x, z
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    return motions.reshape(-1, 6)


def checked(K: csr_array, M: csr_array, motions: Floats, modes: int) -> dict[str, Any]:
    """Numbers of a free body that are the same for every program.

    Returns
    -------
    dict
        ``asymmetry`` of K and ``rigid``, the largest force of a rigid motion, both relative to the
        largest entry of K; ``inertia``, the mass of each rigid motion (three times the mass of the
        body, three moments of inertia); the lowest elastic ``eigenvalues``, so many.
    """
    largest = float(np.abs(K.data).max())
    apart = K - K.T
    forces = np.abs(K @ motions).max(axis=0) / np.abs(motions).max(axis=0)
    shift = -_BELOW * float((K.diagonal() / M.diagonal()).min())
    values = eigsh(
        csc_array(K), modes + _RIGID, csc_array(M), sigma=shift, return_eigenvectors=False
    )
    return {
        "asymmetry": float(np.abs(apart.data).max(initial=0.0)) / largest,
        "rigid": float(forces.max()) / largest,
        "inertia": np.einsum("im,im->m", motions, M @ motions).tolist(),
        "eigenvalues": np.sort(values)[_RIGID:].tolist(),
    }


def matrices_of(program: Ours | PlainDolfinx) -> tuple[csr_array, csr_array]:
    """Stiffness and mass of all components; some programs give the mass of one."""
    K, M = local_part(program.stiffness()), local_part(program.mass())
    return K, of_every_component(M, K.shape[0])


def of_every_component(M: csr_array, size: int) -> csr_array:
    """Mass of a vector field of a size, given that of it or of one component of it."""
    return M if M.shape[0] == size else csr_array(kron(M, eye_array(size // M.shape[0])))
