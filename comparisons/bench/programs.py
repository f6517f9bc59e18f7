"""A quarter of a thick ring, divided alike by every program, and the programs that assemble it.

Lagrange cells have straight edges, their corners on the ring; NURBS represent the ring exactly.
"""

from dataclasses import dataclass
from math import pi
from typing import Any, Literal

from cea.errors import InputError
from cea.material import IsotropicMaterial
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
    def cell(self) -> Literal["hexahedron", "tetrahedron"]:
        """Kind of its Lagrange cells."""
        return "tetrahedron" if self.family == "P" else "hexahedron"


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


class PlainDolfinx:
    """dolfinx as its demos use it, for this machine: both matrices as forms of vectors.

    Quadrature is exact on affine cells.
    """

    def __init__(self, discretisation: Discretisation) -> None:
        cell, degree = discretisation.cell, discretisation.degree
        given = shape_mesh(RING, cell, 1, breaks=breaks_of(RING, discretisation.boxes, {}))
        # Corners of both kinds of cell are listed with the last index fastest, basix has the first.
        order = [0, 4, 2, 6, 1, 5, 3, 7] if cell == "hexahedron" else [0, 1, 2, 3]
        element = basix.ufl.element("Lagrange", cell, 1, shape=(3,))
        mesh = create_mesh(MPI.COMM_SELF, given.cells[:, order], element, given.points)
        self._space = functionspace(mesh, ("Lagrange", degree, (3,)))
        self._degrees = 2 * (degree - (cell == "tetrahedron")), 2 * degree

    def stiffness(self) -> Any:
        """PETSc AIJ, made anew."""
        u, v = ufl.TrialFunction(self._space), ufl.TestFunction(self._space)
        lam, mu = MATERIAL.lame
        strain = ufl.sym(ufl.grad(u))
        stress = lam * ufl.tr(strain) * ufl.Identity(3) + 2 * mu * strain
        return _assembled(ufl.inner(stress, ufl.sym(ufl.grad(v))), self._degrees[0])

    def mass(self) -> Any:
        """PETSc AIJ, made anew."""
        u, v = ufl.TrialFunction(self._space), ufl.TestFunction(self._space)
        return _assembled(MATERIAL.rho * ufl.inner(u, v), self._degrees[1])


def _assembled(integrand: Any, degree: int) -> Any:
    dx = ufl.dx(metadata={"quadrature_degree": degree})
    matrix = assemble_matrix(form(integrand * dx, jit_options=dict(_OPTIONS)))
    matrix.assemble()
    return matrix
