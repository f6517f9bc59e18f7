"""Elastic body on Lagrange elements of dolfinx."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from dolfinx.fem import functionspace
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.checks import check_jacobians
from cea.material import IsotropicMaterial
from cea.mesh import Mesh
from cea.petsc import MPI
from cea.ranks import agreed
from cea.rotation import Rotation
from cea.supports.boundary import Force, Pressure, Spring, Support, check_boundary
from cea.supports.constraints import Constraints
from cea.supports.prescribed import add_prescribed
from cea.surface import TrueSurface
from cea.volume import VolumeCells, VolumeSample
from fe_cea.cells import lagrange_cells
from fe_cea.distribution import distribute, lasting_communicator
from fe_cea.elasticity import Elasticity
from fe_cea.facets import gather_facets
from fe_cea.inputs import check_degrees, check_tags
from fe_cea.loads import Loads
from fe_cea.restriction import Restriction
from fe_cea.sampling import cell_jacobians, sample_volume
from fe_cea.supports import nodal_constraints
from fe_cea.surface import FESurface

_UNKNOWN: Mapping[str, TrueSurface] = MappingProxyType({})


class FEBody:
    """Elastic body on a Lagrange space of a mesh; implements :class:`cea.body.Body`.

    Matrices, loads and surfaces are made when first asked for, and kept; asking is collective.

    Parameters
    ----------
    name
        Name of the body.
    mesh
        Mesh (dolfinx) of triangles, quadrilaterals, tetrahedra or hexahedra.
    facet_tags
        Tags of the boundary facets (dolfinx).
    surface_tags
        Tag of each named surface.
    degree
        Degree of the space, 1 to 4.
    material
        Material.
    supports, springs, pressures, forces
        What holds and loads the named surfaces.
    mass_quadrature
        Degree of the quadrature of the mass; by default that which is exact on affine cells.
        Programs that take fewer points have another mass: 2 is that of the four points of
        quadratic tetrahedra in CalculiX.
    true_surfaces
        By name, surfaces that the facets interpolate, the same on every rank: initial gaps of
        contacts are theirs. Where one is not known, its distance from the facets is estimated from
        the angles between these, and initial gaps that are not above it count as zero.

    Raises
    ------
    InputError
        When the degree is not 1 to 4, that of a quadrature is negative, a surface is unknown or has
        no facets, or a component or spring does not suit the dimension.
    """

    def __init__(
        self,
        name: str,
        mesh: Any,
        facet_tags: Any,
        surface_tags: Mapping[str, int],
        *,
        degree: int,
        material: IsotropicMaterial,
        supports: Sequence[Support] = (),
        springs: Sequence[Spring] = (),
        pressures: Sequence[Pressure] = (),
        forces: Sequence[Force] = (),
        mass_quadrature: int | None = None,
        true_surfaces: Mapping[str, TrueSurface] = _UNKNOWN,
    ) -> None:
        self._name = name
        self._mesh = mesh
        self._comm = lasting_communicator(mesh.comm)
        self._facet_tags = facet_tags
        self._surface_tags = dict(surface_tags)
        self._material = material
        self._supports = tuple(supports)
        self._springs = tuple(springs)
        self._loads = Loads(tuple(pressures), tuple(forces), facet_tags, self._surface_tags)
        field = f"bodies.{name}"
        check_degrees(degree, mass_quadrature, field)
        self._mass_quadrature = mass_quadrature
        self._true_surfaces = dict(true_surfaces)
        check_boundary(supports, springs, pressures, forces, surface_tags, self.dim, field)
        check_tags(facet_tags, surface_tags, self.comm, field)
        with agreed(self.comm):
            check_jacobians(cell_jacobians(mesh), f"{field}.mesh")
        self._space = functionspace(mesh, ("Lagrange", degree, (mesh.geometry.dim,)))

    @classmethod
    def from_mesh(
        cls,
        name: str,
        mesh: Mesh | None,
        *,
        degree: int,
        material: IsotropicMaterial,
        supports: Sequence[Support] = (),
        springs: Sequence[Spring] = (),
        pressures: Sequence[Pressure] = (),
        forces: Sequence[Force] = (),
        mass_quadrature: int | None = None,
        true_surfaces: Mapping[str, TrueSurface] = _UNKNOWN,
        comm: Any = MPI.COMM_WORLD,
    ) -> Self:
        """Body on a mesh given as plain arrays, whose named surfaces become its surfaces.

        Parameters
        ----------
        mesh
            The mesh; only that of rank 0 is read, other ranks may give None.
        comm
            Communicator to spread the mesh over.
        name, degree, material, supports, springs, pressures, forces, mass_quadrature, true_surfaces
            As for :class:`FEBody`.

        Raises
        ------
        InputError
            When rank 0 has no mesh, cells are inverted, or as for :class:`FEBody`.

        Examples
        --------
        A steel cube of one hexahedron, held at its bottom:

        >>> corners = [[x, y, z] for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)]
        >>> surfaces = {"bottom": [[0, 2, 4, 6]], "top": [[1, 3, 5, 7]]}
        >>> mesh = Mesh("hexahedron", 1, corners, [range(8)], surfaces)
        >>> steel = IsotropicMaterial(E=2.1e11, nu=0.3, rho=7800.0)
        >>> held = [Support("bottom")]
        >>> body = FEBody.from_mesh("cube", mesh, degree=2, material=steel, supports=held)
        >>> stiffness, mass = body.stiffness(), body.mass()
        """
        spread = distribute(mesh, comm, f"bodies.{name}.mesh")
        return cls(
            name,
            spread.mesh,
            spread.facet_tags,
            spread.surface_tags,
            degree=degree,
            material=material,
            supports=supports,
            springs=springs,
            pressures=pressures,
            forces=forces,
            mass_quadrature=mass_quadrature,
            true_surfaces=true_surfaces,
        )

    @property
    def name(self) -> str:
        """Name of the body."""
        return self._name

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""
        return int(self._mesh.geometry.dim)

    @property
    def comm(self) -> Any:
        """MPI communicator (mpi4py)."""
        return self._comm

    @property
    def material(self) -> IsotropicMaterial:
        """Its material."""
        return self._material

    @property
    def num_scalar_dofs(self) -> int:
        """Scalar basis functions over all ranks."""
        return int(self._space.dofmap.index_map.size_global)

    @cached_property
    def surfaces(self) -> Mapping[str, FESurface]:
        """Named surfaces."""
        return {
            name: FESurface(
                name,
                gather_facets(self._space, self._facet_tags.find(tag)),
                self.num_scalar_dofs,
                self._true_surfaces.get(name),
            )
            for name, tag in self._surface_tags.items()
        }

    @cached_property
    def expansion(self) -> Any:
        """PETSc AIJ matrix (full x free): displacement of every dof from the free ones."""
        first, last = self._space.dofmap.index_map.local_range
        return self._constraints.expansion(first, last, self.comm)

    @property
    def space(self) -> Any:
        """Lagrange space of displacements (dolfinx)."""
        return self._space

    @property
    def constraints(self) -> Constraints:
        """What supports leave free."""
        return self._constraints

    @cached_property
    def _constraints(self) -> Constraints:
        return nodal_constraints(
            self._space,
            self.surfaces if self._supports else {},
            self._supports,
            self.num_scalar_dofs,
            f"bodies.{self._name}.supports",
        )

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

    @cached_property
    def _elasticity(self) -> Elasticity:
        return Elasticity(
            self._space,
            Restriction(self._constraints, self.expansion),
            self._material,
            [(spring, self._surface_tags[spring.surface]) for spring in self._springs],
            self._facet_tags,
            self._mass_quadrature,
            f"bodies.{self._name}",
        )

    @property
    def dof_positions(self) -> Floats | None:
        """Nodes (m) on every rank, shape (num_scalar_dofs, dim); None where cells are curved more.

        Of a geometry of higher degree than the space, x is no function of the space.
        """
        if self._mesh.geometry.cmaps[0].degree > self._space.ufl_element().degree:
            return None
        return np.concatenate(self.comm.allgather(self.node_positions))

    @property
    def node_positions(self) -> Floats:
        """Nodes of this rank (m), shape (n_local, dim)."""
        first, last = self._space.dofmap.index_map.local_range
        return np.asarray(self._space.tabulate_dof_coordinates()[: last - first, : self.dim])

    def part(self, nodes: NDArray[np.bool_]) -> tuple[Any, Any]:
        """Stiffness (N/m) without springs and mass (kg) of cells within some nodes of this rank."""
        return self._elasticity.part(nodes)

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
        first, last = self._space.dofmap.index_map.local_range
        return self._constraints.prescribed_displacement(first, last, self.expansion)

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

    @cached_property
    def _load(self) -> Any:
        free = self.expansion.createVecRight()
        for full in self._loads.vectors(self._space, self.surfaces):
            self.expansion.multTransposeAdd(full, free, free)
        add_prescribed(free, self)
        return free

    def full_load(self) -> Any:
        """Forces on all dofs, without those of prescribed displacements, PETSc vector (full), N."""
        every = self.expansion.createVecLeft()
        for full in self._loads.vectors(self._space, self.surfaces):
            every.array[:] += full.array_r
        return every

    def geometric_stiffness(self, displacement: Floats) -> Any:
        """Stiffness that stresses of a displacement make, PETSc AIJ (free x free), N/m."""
        return self._elasticity.geometric(displacement)

    def volume_sample(self, subdivisions: int) -> VolumeSample:
        """Sample of the whole body, each cell divided so many times a direction; on every rank.

        Raises
        ------
        InputError
            When subdivisions is less than 1.
        """
        return sample_volume(self._space, subdivisions)

    def volume_cells(self) -> VolumeCells:
        """Lagrange cells of the degree of the space, or of the geometry where higher; collective.

        Complete on every rank.
        """
        return lagrange_cells(self._space)
