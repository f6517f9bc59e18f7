"""Elastic bodies: a space with material, supports, springs and loads.

The *free* vector of a body is what its supports leave of the full one, and its expansion Z
(full x free) goes from one to the other. A backend knows full matrices only: a body adds supports,
springs and loads, and reduces once, to Z^T A Z.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cea.arrays import Floats, Ints
from cea.body.space import Space
from cea.material import IsotropicMaterial
from cea.matrices import antisymmetrised, destroy, symmetrised, total
from cea.petsc import PETSc
from cea.rotation import Rotation
from cea.supports.boundary import Force, Pressure, Spring, Support, check_boundary, through_body
from cea.supports.constraints import Constraints
from cea.supports.loads import foundation, surface_forces
from cea.surface import Surface
from cea.volume import VolumeCells


@dataclass(frozen=True, eq=False)
class Body:
    """Elastic body: matrices without its supports' dofs, loads, named surfaces.

    Matrices are made when first asked for; stiffness, mass and load are kept. Asking is collective.

    Parameters
    ----------
    name
        Name of the body.
    space
        Its discretisation.
    material
        Material.
    supports, springs, pressures, forces
        What holds and loads the named surfaces; springs are part of the stiffness.

    Raises
    ------
    InputError
        When a surface is unknown, or a component, spring or force does not suit the dimension.

    Examples
    --------
    A steel cube of one hexahedron, held at its bottom:

    >>> from cea.mesh import Mesh
    >>> from fe_cea import LagrangeSpace
    >>> corners = [[x, y, z] for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)]
    >>> surfaces = {"bottom": [[0, 2, 4, 6]], "top": [[1, 3, 5, 7]]}
    >>> mesh = Mesh("hexahedron", 1, corners, [range(8)], surfaces)
    >>> steel = IsotropicMaterial(E=2.1e11, nu=0.3, rho=7800.0)
    >>> space = LagrangeSpace.from_mesh(mesh, degree=2)
    >>> body = Body("cube", space, steel, supports=[Support("bottom")])
    >>> stiffness, mass = body.stiffness(), body.mass()
    """

    name: str
    space: Space
    material: IsotropicMaterial
    supports: Sequence[Support] = ()
    springs: Sequence[Spring] = ()
    pressures: Sequence[Pressure] = ()
    forces: Sequence[Force] = ()

    def __post_init__(self) -> None:
        check_boundary(
            self.supports,
            self.springs,
            self.pressures,
            self.forces,
            self.surfaces,
            self.dim,
            f"bodies.{self.name}",
        )

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""
        return self.space.dim

    @property
    def comm(self) -> Any:
        """MPI communicator (mpi4py)."""
        return self.space.comm

    @property
    def num_scalar_dofs(self) -> int:
        """Scalar basis functions over all ranks."""
        return int(self.space.ranges[-1])

    @property
    def surfaces(self) -> Mapping[str, Surface]:
        """Named surfaces."""
        return self.space.surfaces

    @property
    def density(self) -> float:
        """Density (kg/m^3).

        Raises
        ------
        InputError
            When the material has none.
        """
        return self.material.density(f"bodies.{self.name}.material")

    @property
    def _own(self) -> tuple[int, int]:
        """First scalar dof of this rank, and that of the next."""
        first, last = self.space.ranges[self.comm.rank : self.comm.rank + 2]
        return int(first), int(last)

    @cached_property
    def constraints(self) -> Constraints:
        """What supports leave free."""
        return self.space.constrain(self.supports, f"bodies.{self.name}.supports")

    @cached_property
    def expansion(self) -> Any:
        """Z, PETSc AIJ (full x free): displacement of every dof from the free ones."""
        return self.constraints.expansion(*self._own, self.comm)

    def reduced(self, matrix: Any, exactly: Callable[[Any], Any] = symmetrised) -> Any:
        """Z^T A Z of a matrix A of all dofs, PETSc AIJ (free x free); A is freed.

        Parameters
        ----------
        matrix
            A, symmetric or skew to the last bit.
        exactly
            Makes a matrix so again where Z is more than a selection of dofs.
        """
        free = self.constraints.restrict(matrix, self.expansion)
        if free is not matrix:
            destroy(matrix)
        return free if self.constraints.selects else exactly(free)

    def stiffness(self) -> Any:
        """Elastic stiffness with springs, PETSc AIJ (free x free), symmetric, N/m."""
        return self._stiffness

    @cached_property
    def _stiffness(self) -> Any:
        return self.reduced(self.full_stiffness())

    def full_stiffness(self) -> Any:
        """Elastic stiffness with springs of all dofs, PETSc AIJ (full x full), N/m; made anew."""
        stiffness = self.space.stiffness(self.material.lame)
        if (springs := self.full_spring_stiffness()) is not None:
            stiffness.axpy(1.0, springs, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
            destroy(springs)
        return stiffness

    def spring_stiffness(self) -> Any | None:
        """What springs are of the stiffness, PETSc AIJ (free x free), N/m; None without any."""
        return self._spring_stiffness

    @cached_property
    def _spring_stiffness(self) -> Any | None:
        springs = self.full_spring_stiffness()
        return None if springs is None else self.reduced(springs)

    def full_spring_stiffness(self) -> Any | None:
        """What springs are of that of all dofs, PETSc AIJ (full x full), N/m; None without any."""
        if not self.springs:
            return None
        own = slice(*(self.dim * number for number in self._own))
        parts = [foundation(self.surfaces[s.surface], s, own, self.comm) for s in self.springs]
        whole = total(parts)
        destroy(*parts)
        return whole

    def mass(self) -> Any:
        """Consistent mass, PETSc AIJ (free x free), symmetric positive definite, kg."""
        return self._mass

    @cached_property
    def _mass(self) -> Any:
        return self.reduced(self.space.mass(self.density))

    def gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s (:mod:`cea.rotation`), PETSc AIJ (free x free), kg, skew."""
        return self.reduced(self.space.gyroscopic(self.density, rotation), antisymmetrised)

    def convective_stiffness(self, rotation: Rotation) -> Any:
        """Z of a rotation (:mod:`cea.rotation`), PETSc AIJ (free x free), kg, symmetric."""
        return self.reduced(self.space.convective(self.density, rotation))

    def geometric_stiffness(self, displacement: Floats) -> Any:
        """Stiffness that stresses of a displacement make, PETSc AIJ (free x free), N/m."""
        return self.reduced(self.space.geometric_stiffness(self.material.lame, displacement))

    @cached_property
    def prescribed(self) -> Any | None:
        """u_D, displacement of all dofs that supports prescribe (m), PETSc vector (full).

        None where they hold all at zero. The displacement is this and what the free dofs add.
        """
        return self.constraints.prescribed_displacement(*self._own, self.expansion)

    def support_forces(self, force: Floats) -> tuple[Ints, Floats]:
        """Forces of each support, along the directions that it holds and no other.

        Of the sum of all of them on all dofs (N), shape (num_scalar_dofs, dim), the scalar dofs
        that supports hold, shape (m,), and the forces of each support on the body there (N), shape
        (supports, m, dim).
        """
        return self.constraints.support_forces(force, len(self.supports))

    def load(self) -> Any:
        """Z^T (F - K u_D): forces of loads and of prescribed displacements, PETSc (free), N."""
        return self._load

    @cached_property
    def _load(self) -> Any:
        force, free = self.full_load(), self.expansion.createVecRight()
        if self.prescribed is not None:
            stiffness, held = self.full_stiffness(), force.duplicate()
            stiffness.mult(self.prescribed, held)
            force.axpy(-1.0, held)
            destroy(stiffness, held)
        self.expansion.multTranspose(force, free)
        destroy(force)
        return free

    def full_load(self) -> Any:
        """F: forces of loads on all dofs, PETSc vector (full), N."""
        shape = (self.num_scalar_dofs, self.dim)
        forces = surface_forces(self.surfaces, self.pressures, self.forces, shape)
        full = self.expansion.createVecLeft()
        full.setArray(forces[slice(*self._own)].ravel())
        if (through := through_body(self.forces)) is not None:
            volumes, uniform = self.space.mass(1.0), full.duplicate()
            uniform.setArray(np.tile(through, full.getLocalSize() // self.dim))
            volumes.multAdd(uniform, full, full)
            destroy(volumes, uniform)
        return full

    @property
    def dof_positions(self) -> Floats | None:
        """Coefficients of the position x in the space (m), as :attr:`Space.dof_positions`."""
        return self.space.dof_positions

    @property
    def node_positions(self) -> Floats | None:
        """Where the scalar dofs of this rank lie (m), as :attr:`Space.node_positions`."""
        return self.space.node_positions

    def volume_cells(self) -> VolumeCells:
        """Cells of the whole body, as :meth:`Space.volume_cells`."""
        return self.space.volume_cells()
