"""Elastic body of NURBS patches."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.matrices import destroy
from cea.petsc import MPI
from cea.rotation import Rotation
from cea.supports.boundary import (
    Force,
    Pressure,
    Spring,
    Support,
    check_boundary,
    through_body,
)
from cea.supports.constraints import Constraints
from cea.supports.prescribed import add_prescribed
from cea.volume import VolumeCells, VolumeSample
from iga_cea.cells import bezier_cells
from iga_cea.elasticity import Elasticity
from iga_cea.inputs import check_faces, check_patches, checked_continuity, checked_degree
from iga_cea.loads import surface_forces
from iga_cea.multipatch import End, Multipatch, join
from iga_cea.patch import PatchGeometry, refine
from iga_cea.sampling import sample_volume
from iga_cea.supports import face_constraints
from iga_cea.surface import NurbsSurface


class NurbsBody:
    """Body of joined NURBS patches; its trial space is rational with the geometry's weights.

    Matrices are assembled when first asked for, and kept.

    Parameters
    ----------
    name
        Name of the body.
    patches
        Geometry of its patches: degrees, knots, control points, weights, breaks.
    faces
        Faces (patch, axis, side) of each named surface.
    degree
        Degree of the trial space along each parameter, 1 to 8, not below that of the geometry.
    material
        Material.
    continuity
        Continuous derivatives at inserted breaks along each parameter; by default degree - 1.
    supports
        What is held, over whole faces.
    springs
        Elastic foundations, part of the stiffness.
    pressures
        Pressures, part of the load.
    forces
        Forces on surfaces or on every part, part of the load.
    comm
        MPI communicator.

    Raises
    ------
    InputError
        When something does not fit, or patches touch that do not conform.
    """

    def __init__(
        self,
        name: str,
        patches: Sequence[PatchGeometry],
        faces: Mapping[str, Sequence[End]],
        degree: Sequence[int],
        *,
        material: IsotropicMaterial,
        continuity: Sequence[int] | None = None,
        supports: Sequence[Support] = (),
        springs: Sequence[Spring] = (),
        pressures: Sequence[Pressure] = (),
        forces: Sequence[Force] = (),
        comm: Any = MPI.COMM_WORLD,
    ) -> None:
        field = f"bodies.{name}"
        dim = check_patches(patches, f"{field}.patches")
        degree = checked_degree(degree, patches, f"{field}.degree")
        continuity = checked_continuity(continuity, degree, f"{field}.continuity")
        check_faces(faces, patches, dim, f"{field}.faces")
        check_boundary(supports, springs, pressures, forces, faces, dim, field)

        self.name = name
        self.dim = dim
        self.comm = comm
        self.material = material
        self.degree = degree
        self.continuity = continuity
        self._supports = tuple(supports)
        self._springs = tuple(springs)
        self._pressures = tuple(pressures)
        self._forces = tuple(forces)
        self.multipatch: Multipatch = join(
            [refine(patch, degree, continuity) for patch in patches], comm.size, f"{field}.patches"
        )
        self.surfaces: Mapping[str, NurbsSurface] = MappingProxyType(
            {
                surface: NurbsSurface(surface, self.multipatch.faces(ends), self.num_scalar_dofs)
                for surface, ends in faces.items()
            }
        )

    @property
    def num_scalar_dofs(self) -> int:
        """Scalar basis functions over all ranks."""
        return self.multipatch.num_scalar_dofs

    @property
    def control_points(self) -> Floats:
        """Control point of each scalar dof (m), shape (num_scalar_dofs, dim)."""
        return self.multipatch.control_points

    @property
    def expansion(self) -> Any:
        """PETSc AIJ matrix (full x free): displacement of every dof from the free ones."""
        return self._elasticity.expansion

    @property
    def constraints(self) -> Constraints:
        """What supports leave free."""
        return self._constraints

    def stiffness(self) -> Any:
        """Elastic stiffness with springs, PETSc AIJ (free x free), symmetric, N/m."""
        return self._elasticity.stiffness

    def spring_stiffness(self) -> Any | None:
        """What springs are of the stiffness, PETSc AIJ (free x free), N/m; None without any."""
        return self._elasticity.springs

    def mass(self) -> Any:
        """Consistent mass, PETSc AIJ (free x free), symmetric positive definite, kg.

        Raises
        ------
        InputError
            When the material has no density.
        """
        return self._elasticity.mass

    @property
    def dof_positions(self) -> Floats:
        """Control points (m): the trial space is rational with the weights of the geometry."""
        return self.control_points

    @property
    def node_positions(self) -> None:
        """None: functions reach over many knot spans, and no part is assembled alone."""
        return None

    def part(self, nodes: NDArray[np.bool_]) -> tuple[Any, Any]:
        """Refused: no part is assembled alone."""
        raise InputError(f"bodies.{self.name}", "NURBS", "a body of finite elements")

    def gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s (:mod:`cea.rotation`), PETSc AIJ (free x free), kg, skew."""
        return self._elasticity.gyroscopic(rotation)

    def convective_stiffness(self, rotation: Rotation) -> Any:
        """Z of a rotation (:mod:`cea.rotation`), PETSc AIJ (free x free), kg, symmetric."""
        return self._elasticity.convective(rotation)

    @property
    def prescribed(self) -> Any | None:
        """Displacement of all dofs that supports prescribe (m), PETSc vector (full), or None."""
        return self._prescribed

    @cached_property
    def _prescribed(self) -> Any | None:
        first, last = self.multipatch.dof_ranges[self.comm.rank : self.comm.rank + 2]
        return self._constraints.prescribed_displacement(int(first), int(last), self.expansion)

    def full_stiffness(self) -> Any:
        """Elastic stiffness with springs of all dofs, PETSc AIJ (full x full), N/m; made anew."""
        return self._elasticity.full_stiffness()

    def full_spring_stiffness(self) -> Any | None:
        """What springs are of that, PETSc AIJ (full x full), N/m; None without any."""
        return self._elasticity.full_springs()

    def full_gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s of all dofs, PETSc AIJ (full x full), kg; made anew."""
        return self._elasticity.full_gyroscopic(rotation)

    def full_convective_stiffness(self, rotation: Rotation) -> Any:
        """Z of a rotation of all dofs, PETSc AIJ (full x full), kg; made anew."""
        return self._elasticity.full_convective(rotation)

    def support_forces(self, force: Floats) -> tuple[Ints, Floats]:
        """Forces of each support at the dofs that they hold (N), from their sum on all dofs."""
        return self._constraints.support_forces(force, len(self._supports))

    def load(self) -> Any:
        """Forces of loads and of prescribed displacements, PETSc vector (free), N."""
        return self._load

    def geometric_stiffness(self, displacement: Floats) -> Any:
        """Stiffness that stresses of a displacement make, PETSc AIJ (free x free), N/m."""
        return self._elasticity.geometric(displacement)

    def volume_sample(self, subdivisions: int) -> VolumeSample:
        """Sample of the whole body, each knot span divided so many times a direction.

        Complete on every rank. Points on joints of patches appear once for each patch.

        Raises
        ------
        InputError
            When subdivisions is less than 1.
        """
        return sample_volume(self.multipatch, subdivisions)

    def volume_cells(self) -> VolumeCells:
        """Bezier elements of the knot spans. Complete on every rank.

        Points on joints of patches appear once for each patch.
        """
        return bezier_cells(self.multipatch)

    @cached_property
    def _constraints(self) -> Constraints:
        return face_constraints(
            self.surfaces,
            self._supports,
            self.num_scalar_dofs,
            self.dim,
            max(self.degree) + 2,
            f"bodies.{self.name}.supports",
        )

    @property
    def _owned(self) -> slice:
        """Full dofs of this rank."""
        first, last = self.dim * self.multipatch.dof_ranges[self.comm.rank : self.comm.rank + 2]
        return slice(int(first), int(last))

    @cached_property
    def _elasticity(self) -> Elasticity:
        return Elasticity(
            self.multipatch,
            self._constraints,
            self.material,
            self._springs,
            self.surfaces,
            self.comm,
            f"bodies.{self.name}",
        )

    @cached_property
    def _load(self) -> Any:
        load, full = self.expansion.createVecRight(), self.full_load()
        self.expansion.multTranspose(full, load)
        destroy(full)
        add_prescribed(load, self)
        return load

    def full_load(self) -> Any:
        """Forces on all dofs, without those of prescribed displacements, PETSc vector (full), N."""
        shape, points = (self.num_scalar_dofs, self.dim), max(self.degree) + 1
        force = surface_forces(self.surfaces, self._pressures, self._forces, shape, points)
        full = self.expansion.createVecLeft()
        full.setArray(force.ravel()[self._owned])
        if (through := through_body(self._forces)) is not None:
            self._add_body_force(full, through)
        return full

    def _add_body_force(self, full: Any, force: Floats) -> None:
        """Add the forces on all dofs of a force on every part (N/m^3)."""
        volumes = self._elasticity.volumes()
        uniform = volumes.createVecRight()
        uniform.array[:] = np.tile(force, uniform.getLocalSize() // self.dim)
        volumes.multAdd(uniform, full, full)
        destroy(volumes, uniform)
