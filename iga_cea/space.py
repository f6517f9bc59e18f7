"""Displacements on joined NURBS patches."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints
from cea.body.space import VolumeCells
from cea.errors import InputError
from cea.petsc import MPI
from cea.supports.boundary import Support
from cea.supports.constraints import Constraints
from iga_cea.cells import bezier_cells
from iga_cea.collapse import collapsed_lines, face_is_collapsed
from iga_cea.matrices import NurbsMatrices
from iga_cea.multipatch import End, join
from iga_cea.patch import PatchGeometry, check_geometry, refine
from iga_cea.prolongation import prolongation
from iga_cea.supports import face_constraints
from iga_cea.surface import NurbsSurface

MAX_DEGREE = 8
"""Highest degree of a trial space."""


class NurbsSpace(NurbsMatrices):
    """Space of joined NURBS patches, rational with their weights; a :class:`cea.body.Space`.

    Parameters
    ----------
    patches
        Geometry of its patches: degrees, knots, control points, weights, breaks.
    faces
        Faces (patch, axis, side) of each named surface.
    degree
        Degree along each parameter, 1 to 8, not below that of the geometry.
    continuity
        Continuous derivatives at inserted breaks along each parameter; by default degree - 1.
    field
        Name of the body in messages.
    comm
        MPI communicator.

    Raises
    ------
    InputError
        When something does not fit, or patches touch that do not conform.
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
        dim = _check_patches(patches, f"{field}.patches")
        self.degree = _checked_degree(degree, patches, f"{field}.degree")
        self.continuity = _checked_continuity(continuity, self.degree, f"{field}.continuity")
        _check_faces(faces, patches, dim, f"{field}.faces")
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
        """What supports leave free, held over whole faces."""
        count, gauss = self.multipatch.num_scalar_dofs, max(self.degree) + 2
        return face_constraints(self.surfaces, supports, count, self.dim, gauss, field)

    @property
    def dof_positions(self) -> Floats:
        """Control points (m), (num_scalar_dofs, dim): weights are those of the geometry."""
        return self.multipatch.control_points

    def prolongation(self, coarse: "NurbsSpace") -> csr_array:
        """Functions of coarser patches (:mod:`iga_cea.prolongation`)."""
        rank, field = self.comm.rank, f"{self._field}.patches"
        return prolongation(coarse.multipatch, self.multipatch, rank, field)

    def volume_cells(self) -> VolumeCells:
        """Bezier elements of the knot spans. Complete on every rank.

        Points on joints of patches appear once for each patch.
        """
        return bezier_cells(self.multipatch)


def _check_patches(patches: Sequence[PatchGeometry], field: str) -> int:
    """Refuse patches that make no body; return their dimension."""
    if not patches:
        raise InputError(field, patches, "at least one patch")
    dims = {len(patch.degrees) for patch in patches}
    if len(dims) != 1 or not dims <= {2, 3}:
        raise InputError(field, sorted(dims), "patches of one dimension, 2 or 3")
    for number, patch in enumerate(patches):
        check_geometry(patch, f"{field}[{number}]")
    return dims.pop()


def _checked_degree(
    degree: Sequence[int], patches: Sequence[PatchGeometry], field: str
) -> tuple[int, ...]:
    """Degrees of the trial space, none below that of the geometry."""
    dim = len(patches[0].degrees)
    if not _whole_numbers(degree, dim) or not all(1 <= q <= MAX_DEGREE for q in degree):
        raise InputError(field, degree, f"{dim} whole numbers from 1 to {MAX_DEGREE}")
    lowest = np.max([patch.degrees for patch in patches], axis=0)
    if np.any(np.asarray(degree) < lowest):
        allowed = f"at least {tuple(lowest.tolist())}, the degree of the geometry"
        raise InputError(field, degree, allowed)
    return tuple(int(q) for q in degree)


def _checked_continuity(
    continuity: Sequence[int] | None, degree: tuple[int, ...], field: str
) -> tuple[int, ...]:
    """Continuity at inserted breaks, by default the highest."""
    if continuity is None:
        return tuple(q - 1 for q in degree)
    whole = _whole_numbers(continuity, len(degree))
    if not whole or not all(0 <= c < q for c, q in zip(continuity, degree, strict=True)):
        allowed = f"{len(degree)} whole numbers from 0 to the degree {degree} less 1"
        raise InputError(field, continuity, allowed)
    return tuple(int(c) for c in continuity)


def _check_faces(
    faces: Mapping[str, Sequence[End]], patches: Sequence[PatchGeometry], dim: int, field: str
) -> None:
    """Refuse surfaces with no faces, with some that do not exist, or with collapsed ones."""
    collapsed = [collapsed_lines(patch.control_points) for patch in patches]
    for name, ends in faces.items():
        real = [0 <= p < len(patches) and 0 <= a < dim and s in (0, 1) for p, a, s in ends]
        if not real or not all(real) or len(set(ends)) != len(ends):
            allowed = f"different (patch below {len(patches)}, axis below {dim}, side 0 or 1)"
            raise InputError(f"{field}.{name}", tuple(ends), allowed)
        for patch, axis, side in ends:
            if face_is_collapsed(collapsed[patch], axis, side):
                allowed = "faces that are not collapsed to an edge or a point"
                raise InputError(f"{field}.{name}", (patch, axis, side), allowed)


def _whole_numbers(values: Any, count: int) -> bool:
    return len(values) == count and all(isinstance(v, int | np.integer) for v in values)
