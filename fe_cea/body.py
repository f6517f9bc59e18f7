"""Elastic body on Lagrange elements of dolfinx."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, Self

from dolfinx.fem import Function, functionspace
from dolfinx.fem.petsc import assemble_matrix, assemble_vector
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.checks import check_density, check_jacobians
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.matrices import antisymmetrised, symmetrised
from cea.mesh import Mesh
from cea.petsc import MPI, PETSc
from cea.ranks import agreed
from cea.rotation import Rotation
from cea.supports.boundary import (
    Force,
    Pressure,
    Spring,
    Support,
    check_boundary,
    on_surfaces,
    through_body,
)
from cea.supports.constraints import Constraints
from cea.supports.prescribed import add_prescribed
from cea.volume import VolumeCells, VolumeSample
from fe_cea.cells import lagrange_cells
from fe_cea.distribution import distribute
from fe_cea.facets import gather_facets
from fe_cea.forms import (
    body_force_form,
    convective_form,
    geometric_form,
    gyroscopic_form,
    mass_form,
    pressure_form,
    spring_form,
    stiffness_form,
    traction_form,
)
from fe_cea.sampling import cell_jacobians, sample_volume
from fe_cea.supports import nodal_constraints
from fe_cea.surface import FESurface


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
    ) -> None:
        self._name = name
        self._mesh = mesh
        self._facet_tags = facet_tags
        self._surface_tags = dict(surface_tags)
        self._material = material
        self._supports = tuple(supports)
        self._springs = tuple(springs)
        self._pressures = tuple(pressures)
        self._forces = tuple(forces)
        if type(degree) is not int or not 1 <= degree <= 4:
            raise InputError(f"bodies.{name}.degree", degree, "1 to 4")
        if mass_quadrature is not None and mass_quadrature < 0:
            raise InputError(f"bodies.{name}.mass_quadrature", mass_quadrature, "0 or more")
        self._mass_quadrature = mass_quadrature
        field = f"bodies.{name}"
        check_boundary(supports, springs, pressures, forces, surface_tags, self.dim, field)
        self._check_tags()
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
        comm: Any = MPI.COMM_WORLD,
    ) -> Self:
        """Body on a mesh given as plain arrays, whose named surfaces become its surfaces.

        Parameters
        ----------
        mesh
            The mesh; only that of rank 0 is read, other ranks may give None.
        comm
            Communicator to spread the mesh over.
        name, degree, material, supports, springs, pressures, forces, mass_quadrature
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
        )

    def _check_tags(self) -> None:
        for surface, tag in self._surface_tags.items():
            if self.comm.allreduce(len(self._facet_tags.find(tag))) == 0:
                field = f"bodies.{self._name}.surfaces.{surface}"
                raise InputError(field, tag, "the tag of some facets")

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
        return self._mesh.comm

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
            )
            for name, tag in self._surface_tags.items()
        }

    @cached_property
    def expansion(self) -> Any:
        """PETSc AIJ matrix (full x free): displacement of every dof from the free ones."""
        first, last = self._space.dofmap.index_map.local_range
        return self._constraints.expansion(first, last, self.comm)

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
        return self._stiffness

    @cached_property
    def _stiffness(self) -> Any:
        return self._assembled(
            stiffness_form(self._space, self._material, self._tagged_springs, self._facet_tags)
        )

    def spring_stiffness(self) -> Any | None:
        """What springs are of the stiffness, PETSc AIJ (free x free), N/m; None without any."""
        return self._spring_stiffness

    @cached_property
    def _spring_stiffness(self) -> Any | None:
        if not self._springs:
            return None
        form = spring_form(self._space, self._tagged_springs, self._facet_tags)
        return self._assembled(form, with_zeros=False)

    @property
    def _tagged_springs(self) -> list[tuple[Spring, int]]:
        return [(spring, self._surface_tags[spring.surface]) for spring in self._springs]

    def mass(self) -> Any:
        """Consistent mass, PETSc AIJ (free x free), symmetric positive definite, kg.

        Raises
        ------
        InputError
            When the material has no density.
        """
        return self._mass

    @cached_property
    def _mass(self) -> Any:
        form = mass_form(self._space, self._density, self._mass_quadrature)
        return self._assembled(form, with_zeros=False)

    def gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s (:mod:`cea.rotation`), PETSc AIJ (free x free), kg, skew."""
        form = gyroscopic_form(self._space, self._density, rotation)
        return antisymmetrised(self._restricted(form, with_zeros=False))

    def convective_stiffness(self, rotation: Rotation) -> Any:
        """Z of a rotation (:mod:`cea.rotation`), PETSc AIJ (free x free), kg, symmetric."""
        return self._assembled(
            convective_form(self._space, self._density, rotation), with_zeros=False
        )

    @property
    def _density(self) -> float:
        return check_density(self._material, f"bodies.{self._name}.material")

    def _assembled(self, form: Any, *, with_zeros: bool = True) -> Any:
        """Matrix (free x free) of a symmetric form, symmetric to the last bit."""
        # Element matrices, and products with a turned frame, are symmetric up to rounding only.
        return symmetrised(self._restricted(form, with_zeros=with_zeros))

    def _restricted(self, form: Any, *, with_zeros: bool) -> Any:
        """Matrix (free x free) of a form."""
        full = assemble_matrix(form)
        full.assemble()
        if not with_zeros:  # ahead of all that copies it
            full = _without_zeros(full, self.comm)
        free = self._constraints.restrict(full, self.expansion)
        if free is not full:
            full.destroy()
        return free

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
        form = stiffness_form(self._space, self._material, self._tagged_springs, self._facet_tags)
        full = assemble_matrix(form)
        full.assemble()
        return full

    def load(self) -> Any:
        """Forces of loads and of prescribed displacements, PETSc vector (free), N."""
        return self._load

    @cached_property
    def _load(self) -> Any:
        free = self.expansion.createVecRight()
        for full in self._full_loads():
            self.expansion.multTransposeAdd(full, free, free)
        add_prescribed(free, self)
        return free

    def full_load(self) -> Any:
        """Forces on all dofs, without those of prescribed displacements, PETSc vector (full), N."""
        every = self.expansion.createVecLeft()
        for full in self._full_loads():
            every.array[:] += full.array_r
        return every

    def _full_loads(self) -> Iterator[Any]:
        """Forces on all dofs whose sum is the load, PETSc vectors."""
        for form in self._load_forms():
            full = assemble_vector(form)
            full.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
            yield full

    def geometric_stiffness(self, displacement: Floats) -> Any:
        """Stiffness that stresses of a displacement make, PETSc AIJ (free x free), N/m."""
        u = Function(self._space)
        first, last = self._space.dofmap.index_map.local_range
        mine = slice(self.dim * first, self.dim * last)
        u.x.array[: self.dim * (last - first)] = displacement[mine]
        u.x.scatter_forward()
        return self._assembled(geometric_form(u, self._material))

    def _load_forms(self) -> Iterator[Any]:
        """Linear forms whose sum is the load."""
        if self._pressures:
            pressures = [(p, self._surface_tags[p.surface]) for p in self._pressures]
            yield pressure_form(self._space, pressures, self._facet_tags)
        for name, value in on_surfaces(self._forces):
            traction = value / self.surfaces[name].area
            yield traction_form(self._space, traction, self._surface_tags[name], self._facet_tags)
        if (through := through_body(self._forces)) is not None:
            yield body_force_form(self._space, through)

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


def _without_zeros(matrix: Any, comm: Any) -> Any:
    """AIJ matrix without stored zeros, two thirds of a mass matrix in 3D; the given one goes."""
    sizes = matrix.getSizes()
    indptr, indices, values = matrix.getValuesCSR()
    matrix.destroy()
    rows = csr_array((values, indices, indptr), shape=(len(indptr) - 1, sizes[1][1]))
    rows.eliminate_zeros()
    return PETSc.Mat().createAIJ(sizes, csr=(rows.indptr, rows.indices, rows.data), comm=comm)
