"""What scenes are made of: both backends, through their bodies."""

from typing import Any

from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import spsolve

from cea.arrays import Floats
from cea.matrices import local_part
from comparisons.bench.programs.annulus import MATERIAL, Discretisation, rigid_motions, ring
from scenes.building.build import build_body
from scenes.spec.body import BodySpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec


class Ours:
    """A body of this program without supports."""

    def __init__(self, discretisation: Discretisation) -> None:
        degree, boxes = discretisation.degree, discretisation.boxes
        if discretisation.family == "NURBS":
            spec = BodySpec("iga", ring(), MATERIAL, MeshSpec(iga=IgaMesh((degree,) * 3, boxes)))
        else:
            mesh = FeMesh(discretisation.cell, degree, geometry_degree=1, elements=boxes)
            spec = BodySpec("fe", ring(), MATERIAL, MeshSpec(fe=mesh))
        self._body = build_body("ring", spec)

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
