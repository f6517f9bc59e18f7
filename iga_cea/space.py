"""Displacement space of joined NURBS patches."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints
from cea.body import VolumeCells
from cea.errors import InputError, require
from cea.petsc import MPI
from cea.supports.boundary import Support
from cea.supports.constraints import Constraints
from iga_cea.cells import bezier_cells
from iga_cea.collapse import collapsed_lines, face_is_collapsed
from iga_cea.matrices import NurbsMatrices
from iga_cea.multipatch import End, join
from iga_cea.patch import PatchGeometry, check_map, refine
from iga_cea.prolongation import prolongation
from iga_cea.supports import face_constraints
from iga_cea.surface import NurbsSurface


class NurbsSpace(NurbsMatrices):
    """Space of joined NURBS patches with the weights of the geometry; a :class:`cea.body.Space`.

    Parameters
    ----------
    patches
        Geometry of the patches: degrees, knots, control points, weights, breaks.
    faces
        Faces (patch, axis, side) of each named surface.
    degree
        Degree along each parameter, at least that of the geometry.
    continuity
        Number of continuous derivatives at inserted breaks; by default degree - 1.
    field
        Name of the body in messages.
    comm
        MPI communicator.

    Raises
    ------
    InputError
        If a patch is folded, a degree or face is invalid, or patches touch without being
        conforming.
    """

    def __init__(
        self,
        patches: Sequence[PatchGeometry],
        faces: Mapping[str, Sequence[End]],
        degree: Sequence[int],
        *,
        continuity: Sequence[int] | None = None,
        field: str = "body",
        comm: Any = MPI.COMM_WORLD,
    ) -> None:
        for number, patch in enumerate(patches):
            check_map(patch, f"{field}.patches[{number}]")
        self.degree = tuple(degree)
        self.continuity = tuple(continuity or (q - 1 for q in degree))
        _check_degree(self.degree, patches, f"{field}.degree")
        _check_faces(faces, patches, f"{field}.faces")
        self._field = field
        refined = [refine(patch, self.degree, self.continuity) for patch in patches]
        super().__init__(join(refined, comm.size, f"{field}.patches"), comm)
        count = self.multipatch.num_scalar_dofs
        self.surfaces: Mapping[str, NurbsSurface] = MappingProxyType(
            {
                name: NurbsSurface(name, self.multipatch.faces(ends), count)
                for name, ends in faces.items()
            }
        )

    @property
    def ranges(self) -> Ints:
        """First scalar dof of each rank, and the end of the last, (ranks + 1,)."""
        return self.multipatch.dof_ranges

    def constrain(self, supports: Sequence[Support], field: str) -> Constraints:
        """Return the constraints of supports over whole faces."""
        count, gauss = self.multipatch.num_scalar_dofs, max(self.degree) + 2
        return face_constraints(self.surfaces, supports, count, self.dim, gauss, field)

    @property
    def dof_positions(self) -> Floats:
        """Control points (m), (num_scalar_dofs, dim): weights are those of the geometry."""
        return self.multipatch.control_points

    def prolongation(self, coarse: "NurbsSpace") -> csr_array:
        """Return the functions of a coarser space (:mod:`iga_cea.prolongation`)."""
        rank, field = self.comm.rank, f"{self._field}.patches"
        return prolongation(coarse.multipatch, self.multipatch, rank, field)

    def volume_cells(self) -> VolumeCells:
        """Return Bezier elements of the knot spans, complete on every rank.

        Points on joints are duplicated, once for each patch.
        """
        return bezier_cells(self.multipatch)


def _check_degree(degree: tuple[int, ...], patches: Sequence[PatchGeometry], field: str) -> None:
    """Raise InputError if a degree is below that of the geometry."""
    lowest = np.max([patch.degrees for patch in patches], axis=0)
    allowed = f"at least {tuple(lowest.tolist())}, the degree of the geometry"
    require(bool(np.all(np.asarray(degree) >= lowest)), field, degree, allowed)


def _check_faces(
    faces: Mapping[str, Sequence[End]], patches: Sequence[PatchGeometry], field: str
) -> None:
    """Raise InputError if a surface has a collapsed face."""
    collapsed = [collapsed_lines(patch.control_points) for patch in patches]
    for name, ends in faces.items():
        for patch, axis, side in ends:
            if face_is_collapsed(collapsed[patch], axis, side):
                allowed = "faces that are not collapsed to an edge or a point"
                raise InputError(f"{field}.{name}", (patch, axis, side), allowed)
