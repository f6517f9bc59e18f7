"""Matrices of a body of NURBS patches: of its material, springs and rotation."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

from cea.arrays import Floats
from cea.checks import check_density
from cea.material import IsotropicMaterial
from cea.matrices import antisymmetrised, destroy, symmetrised, total
from cea.petsc import PETSc
from cea.rotation import Rotation
from cea.supports.boundary import Spring
from cea.supports.constraints import Constraints
from iga_cea import assembly, prestress, transport
from iga_cea.multipatch import Multipatch
from iga_cea.pattern import Pattern
from iga_cea.springs import foundation
from iga_cea.storage import Kept
from iga_cea.surface import NurbsSurface


class Elasticity:
    """Matrices of a body on its free dofs (free x free); those without arguments are kept.

    Parameters
    ----------
    multipatch
        The joined patches.
    constraints
        What supports leave free.
    material
        Material.
    springs
        Elastic foundations, part of the stiffness.
    surfaces
        Named surfaces.
    comm
        MPI communicator.
    field
        Name of the body in messages.
    """

    def __init__(
        self,
        multipatch: Multipatch,
        constraints: Constraints,
        material: IsotropicMaterial,
        springs: Sequence[Spring],
        surfaces: Mapping[str, NurbsSurface],
        comm: Any,
        field: str,
    ) -> None:
        self._multipatch = multipatch
        self._constraints = constraints
        self._material = material
        self._springs = springs
        self._surfaces = surfaces
        self._comm = comm
        self._field = field

    @cached_property
    def expansion(self) -> Any:
        """PETSc AIJ matrix (full x free): displacement of every dof from the free ones."""
        return self._constraints.expansion(*self._dofs, self._comm)

    @cached_property
    def stiffness(self) -> Any:
        """Elastic stiffness with springs, N/m."""
        return self._restricted(self._elastic(self._kept))

    @cached_property
    def springs(self) -> Any | None:
        """What springs are of the stiffness (N/m), or None without any."""
        whole = self.full_springs()
        if whole is None:
            return None
        if self._kept is None:
            return self._restricted(whole)
        return self._cut(whole)

    @cached_property
    def mass(self) -> Any:
        """Consistent mass, kg."""
        return self._restricted(assembly.mass(*self._space, self._density, self._comm, self._kept))

    def volumes(self) -> Any:
        """Mass at a density of 1 of all dofs (full x full), m^3; made anew."""
        return assembly.mass(*self._space, 1.0, self._comm)

    def full_stiffness(self) -> Any:
        """Elastic stiffness with springs of all dofs (full x full), N/m; made anew."""
        return self._elastic(None)

    def full_springs(self) -> Any | None:
        """What springs are of that (full x full), N/m, or None without any; made anew."""
        if not self._springs:
            return None
        foundations = [self._foundation(spring) for spring in self._springs]
        whole = total(foundations)
        destroy(*foundations)
        return whole

    def gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s (:mod:`cea.rotation`), kg, skew."""
        whole = transport.gyroscopic(*self._space, self._density, rotation, self._comm, self._kept)
        return self._restricted(whole, antisymmetrised)

    def convective(self, rotation: Rotation) -> Any:
        """Z of a rotation (:mod:`cea.rotation`), kg, symmetric."""
        whole = transport.convective_stiffness(
            *self._space, self._density, rotation, self._comm, self._kept
        )
        return self._restricted(whole)

    def full_gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s of all dofs (full x full), kg; made anew."""
        return transport.gyroscopic(*self._space, self._density, rotation, self._comm)

    def full_convective(self, rotation: Rotation) -> Any:
        """Z of a rotation of all dofs (full x full), kg; made anew."""
        return transport.convective_stiffness(*self._space, self._density, rotation, self._comm)

    def geometric(self, displacement: Floats) -> Any:
        """Stiffness that stresses of a displacement (m) of all dofs make, N/m."""
        u = displacement.reshape(-1, self._multipatch.dim)
        whole = prestress.geometric_stiffness(
            *self._space, self._material, u, self._comm, self._kept
        )
        return self._restricted(whole)

    @property
    def _space(self) -> tuple[Multipatch, Pattern]:
        return self._multipatch, self._pattern

    @property
    def _dofs(self) -> tuple[int, int]:
        """First scalar dof of this rank, and of the next one."""
        first, last = self._multipatch.dof_ranges[self._comm.rank : self._comm.rank + 2]
        return int(first), int(last)

    @cached_property
    def _pattern(self) -> Pattern:
        return Pattern.of(self._multipatch, self._comm.rank)

    @property
    def _density(self) -> float:
        return check_density(self._material, f"{self._field}.material")

    def _elastic(self, kept: Kept | None) -> Any:
        """Stiffness with springs of the unknowns that are kept."""
        K = assembly.stiffness(*self._space, self._material.lame, self._comm, kept)
        for spring in self._springs:
            added = self._foundation(spring)
            if kept is not None:
                added = self._cut(added)
            K.axpy(1.0, added, structure=PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
            added.destroy()
        return K

    def _foundation(self, spring: Spring) -> Any:
        """Matrix of a spring, all dofs."""
        points = max(max(patch.degrees) for patch in self._multipatch.patches) + 1
        owned = slice(*(self._multipatch.dim * number for number in self._dofs))
        return foundation(self._surfaces[spring.surface], spring, points, owned, self._comm)

    @cached_property
    def _kept(self) -> Kept | None:
        """Unknowns that supports leave, where matrices are assembled for them alone."""
        constraints = self._constraints
        return constraints.kept if constraints.any and constraints.selects else None

    def _restricted(self, matrix: Any, exactly: Callable[[Any], Any] = symmetrised) -> Any:
        """Rows and columns of the free unknowns, where the matrix is not assembled for them."""
        if self._kept is not None or not self._constraints.any:
            return matrix
        return exactly(self._cut(matrix))  # products with a turned frame are so up to rounding only

    def _cut(self, matrix: Any) -> Any:
        """Rows and columns of the free unknowns of a matrix of all, which is freed."""
        restricted = self._constraints.restrict(matrix, self.expansion)
        matrix.destroy()
        return restricted
