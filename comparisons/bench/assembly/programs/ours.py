"""What scenes are made of: both backends, through their bodies."""

from typing import Any

from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import spsolve

from cea.arrays import Floats
from cea.body import Body
from cea.matrices import local_part
from comparisons.bench.annulus import MATERIAL, Discretisation, ring
from comparisons.bench.rigid import rigid_motions
from scenes.building.build import build_body
from scenes.spec.body import BodySpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec


class Ours:
    """A body of this program."""

    def __init__(self, body: Body) -> None:
        self._body = body

    def stiffness(self) -> Any:
        """PETSc AIJ."""
        return self._body.stiffness()

    def mass(self) -> Any:
        """PETSc AIJ."""
        return self._body.mass()

    def compressed(self, matrix: Any) -> csr_array:
        """Rows of a matrix."""
        return local_part(matrix)

    def motions(self) -> Floats:
        """Rigid motions by nodes or control points."""
        cells = self._body.volume_cells()
        # Positions are a field of the space: those coefficients that give it at the points.
        values = csc_array(cells.values)
        return rigid_motions(spsolve(values.T @ values, values.T @ cells.points))


def lay_out(discretisation: Discretisation) -> Ours:
    """A body without supports."""
    degree, boxes = discretisation.degree, discretisation.boxes
    if discretisation.family == "NURBS":
        mesh = MeshSpec(iga=IgaMesh((degree,) * 3, boxes))
        return Ours(build_body("ring", BodySpec("iga", ring(), MATERIAL, mesh)))
    mesh = MeshSpec(fe=FeMesh(discretisation.cell, degree, geometry_degree=1, elements=boxes))
    return Ours(build_body("ring", BodySpec("fe", ring(), MATERIAL, mesh)))
