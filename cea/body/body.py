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
from scipy.sparse import csr_array, diags_array, kron

from cea.arrays import Floats, Ints
from cea.body.space import Space
from cea.elasticity import Elasticity
from cea.material import Material
from cea.matrices import antisymmetrised, destroy, distributed, symmetrised, total
from cea.petsc import PETSc
from cea.rotation import Rotation
from cea.supports.boundary import Force, Pressure, Spring, Support, check_surface
from cea.supports.constraints import Constraints
from cea.surface import Surface


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

    >>> from cea.material import IsotropicMaterial
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
    material: Material
    supports: Sequence[Support] = ()
    springs: Sequence[Spring] = ()
    pressures: Sequence[Pressure] = ()
    forces: Sequence[Force] = ()

    def __post_init__(self) -> None:
        conditions: dict[str, Sequence[Support | Spring | Pressure | Force]] = {
            "supports": self.supports,
            "springs": self.springs,
            "pressures": self.pressures,
            "forces": self.forces,
        }
        for kind, items in conditions.items():
            for number, item in enumerate(items):
                place = f"bodies.{self.name}.{kind}[{number}]"
                if item.surface is not None:
                    check_surface(item.surface, self.surfaces, f"{place}.surface")
                item.check(self.dim, place)

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
        """Density (kg/m^3), refused where the material has none."""
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

        A is symmetric or skew to the last bit, and ``exactly`` makes the product so again where Z
        is more than a selection of dofs.
        """
        if not len(self.constraints.dofs):
            return matrix
        free = self.constraints.restrict(matrix, self.expansion)
        destroy(matrix)
        return free if self.constraints.selects else exactly(free)

    def stiffness(self) -> Any:
        """Elastic stiffness with springs, PETSc AIJ (free x free), symmetric, N/m."""
        return self._stiffness

    @cached_property
    def _stiffness(self) -> Any:
        return self.reduced(self.full_stiffness())

    def stiffness_of(self, elasticity: Elasticity) -> Any:
        """Elastic stiffness of another law, PETSc AIJ (free x free), symmetric, N/m; made anew."""
        return self.reduced(self.space.stiffness(elasticity))

    def full_stiffness(self) -> Any:
        """Elastic stiffness with springs of all dofs, PETSc AIJ (full x full), N/m; made anew."""
        stiffness = self.space.stiffness(self.material.elasticity)
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
        parts = [_foundation(self.surfaces[s.surface], s, own, self.comm) for s in self.springs]
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
        return self.reduced(self.space.geometric_stiffness(self.material.elasticity, displacement))

    @cached_property
    def prescribed(self) -> Any | None:
        """u_D, displacement of all dofs that supports prescribe (m), PETSc; None where zero."""
        return self.constraints.prescribed_displacement(*self._own, self.expansion)

    def support_forces(self, force: Floats) -> tuple[Ints, Floats]:
        """Of a sum of forces on all dofs (N), (num_scalar_dofs, dim), those of each support.

        The scalar dofs that supports hold, shape (m,), and the forces there, (supports, m, dim),
        along the directions that each holds and no other.
        """
        held = self.constraints
        return held.dofs, held.forces.split(force[held.dofs], len(self.supports))

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
        forces = _surface_forces(self.surfaces, self.pressures, self.forces, shape)
        full = self.expansion.createVecLeft()
        full.setArray(forces[slice(*self._own)].ravel())
        through = [force.value for force in self.forces if force.surface is None]
        if through:
            volumes, uniform = self.space.mass(1.0), full.duplicate()
            uniform.setArray(np.tile(np.sum(through, axis=0), full.getLocalSize() // self.dim))
            volumes.multAdd(uniform, full, full)
            destroy(volumes, uniform)
        return full


def _foundation(surface: Surface, spring: Spring, own: slice, comm: Any) -> Any:
    """Matrix of a spring: int k_c phi_m phi_n on the diagonal of components c."""
    points = surface.gauss_points(surface.cells().degree + 1)
    scaled = diags_array(np.sqrt(points.weight)) @ surface.trace(points.at)
    scalar = csr_array(scaled.T @ scaled)
    whole = csr_array(kron(scalar, diags_array(np.asarray(spring.stiffness)), format="csr"))
    rows = csr_array(whole[own])
    return distributed(rows, rows.shape, comm)


def _surface_forces(
    surfaces: Mapping[str, Surface],
    pressures: Sequence[Pressure],
    forces: Sequence[Force],
    shape: tuple[int, int],
) -> Floats:
    """Forces of loads on surfaces on all scalar dofs (N); those on every part are left out."""
    total = np.zeros(shape)
    for pressure in pressures:
        surface = surfaces[pressure.surface]
        # Of facets of degree q, function times normal times area element has up to 3 q - 1.
        points = surface.gauss_points((3 * surface.cells().degree + 1) // 2)
        traction = -pressure.value * points.normal
        total += surface.trace(points.at).T @ (points.weight[:, None] * traction)
    for force in forces:
        if force.surface is not None:
            surface = surfaces[force.surface]
            points = surface.gauss_points(surface.cells().degree + 1)
            share = surface.trace(points.at).T @ points.weight
            total += share[:, None] * np.array(force.value) / points.weight.sum()
    return total
