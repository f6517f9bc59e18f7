"""Matrices of an elastic body on a Lagrange space: of its material, springs and rotation."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from dolfinx.fem import Function
from dolfinx.fem.petsc import assemble_matrix
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.checks import check_density
from cea.material import IsotropicMaterial
from cea.matrices import antisymmetrised, destroy
from cea.petsc import PETSc
from cea.rotation import Rotation
from cea.supports.boundary import Spring
from fe_cea.assembly import Assembly, cells_within
from fe_cea.forms import convective_form, geometric_form, gyroscopic_form, spring_form
from fe_cea.restriction import Restriction


class Elasticity:
    """Matrices of a body on its free dofs (free x free); those without arguments are kept.

    Parameters
    ----------
    V
        Vector Lagrange space (dolfinx).
    restriction
        To the free dofs.
    material
        Material.
    springs
        Springs, each with the facet tag of its surface.
    facet_tags
        Tags of the boundary facets (dolfinx).
    mass_quadrature
        Degree of the quadrature of the mass, by default exact on affine cells.
    field
        Name of the body in messages.
    """

    def __init__(
        self,
        V: Any,
        restriction: Restriction,
        material: IsotropicMaterial,
        springs: Sequence[tuple[Spring, int]],
        facet_tags: Any,
        mass_quadrature: int | None,
        field: str,
    ) -> None:
        self._space = V
        self._restriction = restriction
        self._material = material
        self._springs = springs
        self._facet_tags = facet_tags
        self._mass_quadrature = mass_quadrature
        self._field = field

    @cached_property
    def stiffness(self) -> Any:
        """Elastic stiffness with springs, N/m."""
        lame = self._material.lame
        stiffness = self._restriction.of_free(lambda held: self._assembly.stiffness(lame, held))
        return _with_springs(stiffness, self.springs)

    @cached_property
    def springs(self) -> Any | None:
        """What springs are of the stiffness (N/m), or None without any."""
        if not self._springs:
            return None
        return self._restriction.symmetric(self._spring_form, with_zeros=False)

    @cached_property
    def mass(self) -> Any:
        """Consistent mass, kg."""
        rho, degree = self._density, self._mass_quadrature
        return self._restriction.of_free(lambda held: self._assembly.mass(rho, held, degree))

    def part(self, nodes: NDArray[np.bool_]) -> tuple[Any, Any]:
        """Stiffness (N/m) without springs and mass (kg) of cells within some nodes of this rank."""
        assembly = Assembly(self._space, cells_within(self._space, nodes))
        lame, rho, degree = self._material.lame, self._density, self._mass_quadrature
        stiffness = self._restriction.of_free(lambda held: assembly.stiffness(lame, held))
        return stiffness, self._restriction.of_free(lambda held: assembly.mass(rho, held, degree))

    @cached_property
    def _assembly(self) -> Assembly:
        return Assembly(self._space)

    @property
    def _spring_form(self) -> Any:
        return spring_form(self._space, self._springs, self._facet_tags)

    @property
    def _density(self) -> float:
        return check_density(self._material, f"{self._field}.material")

    def full_stiffness(self) -> Any:
        """Elastic stiffness with springs of all dofs (full x full), N/m."""
        stiffness, springs = self._assembly.stiffness(self._material.lame), self.full_springs()
        _with_springs(stiffness, springs)
        if springs is not None:
            destroy(springs)
        return stiffness

    def full_springs(self) -> Any | None:
        """What springs are of that (full x full), N/m, or None without any; made anew."""
        if not self._springs:
            return None
        return _full(self._spring_form)

    def gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s (:mod:`cea.rotation`), kg, skew."""
        return self._restriction.skew(gyroscopic_form(self._space, self._density, rotation))

    def convective(self, rotation: Rotation) -> Any:
        """Z of a rotation (:mod:`cea.rotation`), kg, symmetric."""
        form = convective_form(self._space, self._density, rotation)
        return self._restriction.symmetric(form, with_zeros=False)

    def full_gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s of all dofs (full x full), kg; made anew."""
        return antisymmetrised(_full(gyroscopic_form(self._space, self._density, rotation)))

    def full_convective(self, rotation: Rotation) -> Any:
        """Z of a rotation of all dofs (full x full), kg; made anew."""
        return _full(convective_form(self._space, self._density, rotation))

    def geometric(self, displacement: Floats) -> Any:
        """Stiffness that stresses of a displacement (m) of all dofs make, N/m."""
        u = Function(self._space)
        dim = self._space.mesh.geometry.dim
        first, last = self._space.dofmap.index_map.local_range
        u.x.array[: dim * (last - first)] = displacement[dim * first : dim * last]
        u.x.scatter_forward()
        return self._restriction.symmetric(geometric_form(u, self._material))


def _full(form: Any) -> Any:
    """Matrix of a form (dolfinx) on all dofs."""
    matrix = assemble_matrix(form)
    matrix.assemble()
    return matrix


def _with_springs(stiffness: Any, springs: Any | None) -> Any:
    """Add springs, whose entries the stiffness has, in place."""
    if springs is not None:
        stiffness.axpy(1.0, springs, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
    return stiffness
