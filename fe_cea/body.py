"""Elastic body on Lagrange elements of dolfinx."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Self

import numpy as np
from dolfinx.fem import functionspace, locate_dofs_topological
from dolfinx.fem.petsc import assemble_matrix, assemble_vector
from dolfinx.io.gmsh import model_to_mesh
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse import csr_array

from cea.body import VolumeSample
from cea.boundary import Pressure, Spring, Support
from cea.errors import InputError
from cea.material import IsotropicMaterial
from fe_cea.facets import gather_facets
from fe_cea.forms import mass_form, pressure_form, stiffness_form
from fe_cea.sampling import sample_volume
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
    supports, springs, pressures
        What holds and loads the named surfaces.

    Raises
    ------
    InputError
        When the degree is not 1 to 4, a surface is unknown or has no facets, or a component or
        spring does not suit the dimension.
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
    ) -> None:
        self._name = name
        self._mesh = mesh
        self._facet_tags = facet_tags
        self._surface_tags = dict(surface_tags)
        self._material = material
        self._supports = tuple(supports)
        self._springs = tuple(springs)
        self._pressures = tuple(pressures)
        if not 1 <= degree <= 4:
            raise InputError(f"bodies.{name}.degree", degree, "1 to 4")
        self._check_surfaces()
        self._check_components()
        self._space = functionspace(mesh, ("Lagrange", degree, (mesh.geometry.dim,)))

    @classmethod
    def from_gmsh(
        cls,
        name: str,
        model: Any,
        *,
        degree: int,
        material: IsotropicMaterial,
        supports: Sequence[Support] = (),
        springs: Sequence[Spring] = (),
        pressures: Sequence[Pressure] = (),
        comm: Any = MPI.COMM_WORLD,
    ) -> Self:
        """Body on the mesh of a gmsh model, whose physical surfaces become its surfaces.

        Parameters
        ----------
        model
            Meshed gmsh model; only that of rank 0 is read.
        comm
            Communicator to spread the mesh over.
        name, degree, material, supports, springs, pressures
            As for :class:`FEBody`.
        """
        dim = comm.bcast(model.getDimension() if comm.rank == 0 else None, root=0)
        data = model_to_mesh(model, comm, 0, gdim=dim)
        tags = {
            group: physical.tag
            for group, physical in data.physical_groups.items()
            if physical.dim == dim - 1 and group
        }
        return cls(
            name,
            data.mesh,
            data.facet_tags,
            tags,
            degree=degree,
            material=material,
            supports=supports,
            springs=springs,
            pressures=pressures,
        )

    def _check_surfaces(self) -> None:
        known = self._surface_tags
        conditions_of: dict[str, Sequence[Support | Spring | Pressure]] = {
            "supports": self._supports,
            "springs": self._springs,
            "pressures": self._pressures,
        }
        for kind, conditions in conditions_of.items():
            for i, condition in enumerate(conditions):
                if condition.surface not in known:
                    raise InputError(
                        f"bodies.{self._name}.{kind}[{i}].surface",
                        condition.surface,
                        f"one of {', '.join(known) or 'none: the mesh names no surfaces'}",
                    )
        for surface, tag in known.items():
            if self.comm.allreduce(len(self._facet_tags.find(tag))) == 0:
                raise InputError(
                    f"bodies.{self._name}.surfaces.{surface}", tag, "the tag of some facets"
                )

    def _check_components(self) -> None:
        for i, support in enumerate(self._supports):
            if max(support.components) >= self.dim:
                raise InputError(
                    f"bodies.{self._name}.supports[{i}].components",
                    support.components,
                    f"below {self.dim}",
                )
        for i, spring in enumerate(self._springs):
            if len(spring.stiffness) != self.dim:
                raise InputError(
                    f"bodies.{self._name}.springs[{i}].stiffness",
                    spring.stiffness,
                    f"{self.dim} components (N/m^3)",
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
        free = self._free
        local = self.dim * self._space.dofmap.index_map.size_local
        first = self._space.dofmap.index_map.local_range[0] * self.dim
        columns = self.comm.exscan(len(free)) or 0  # none on rank 0
        row_starts = np.searchsorted(free, first + np.arange(local + 1))
        index = PETSc.IntType
        return PETSc.Mat().createAIJ(
            ((local, PETSc.DETERMINE), (len(free), PETSc.DETERMINE)),
            csr=(
                row_starts.astype(index),
                (columns + np.arange(len(free))).astype(index),
                np.ones(len(free)),
            ),
            comm=self.comm,
        )

    @cached_property
    def _free(self) -> np.ndarray:
        """Global full dofs of this rank that no support holds, rising."""
        dofmap, topology = self._space.dofmap, self._mesh.topology
        facet_dim = topology.dim - 1
        topology.create_connectivity(facet_dim, topology.dim)
        owned = dofmap.index_map.size_local
        held = np.zeros((owned + dofmap.index_map.num_ghosts, self.dim), dtype=bool)
        for support in self._supports:
            facets = self._facet_tags.find(self._surface_tags[support.surface])
            blocks = locate_dofs_topological(self._space, facet_dim, facets)
            held[np.ix_(blocks, support.components)] = True
        first = dofmap.index_map.local_range[0] * self.dim
        return first + np.flatnonzero(~held[:owned].ravel())

    def stiffness(self) -> Any:
        """Elastic stiffness with springs, PETSc AIJ (free x free), symmetric, N/m."""
        return self._stiffness

    @cached_property
    def _stiffness(self) -> Any:
        springs = [(spring, self._surface_tags[spring.surface]) for spring in self._springs]
        return self._assembled(
            stiffness_form(self._space, self._material, springs, self._facet_tags)
        )

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
        if self._material.rho is None:
            raise InputError(
                f"bodies.{self._name}.material.rho",
                None,
                "a density (kg/m^3) is needed for a mass matrix",
            )
        return _without_zeros(self._assembled(mass_form(self._space, self._material.rho)))

    def _assembled(self, form: Any) -> Any:
        """Matrix (free x free) of a symmetric form, symmetric to the last bit."""
        full = assemble_matrix(form)
        full.assemble()
        free = PETSc.IS().createGeneral(self._free.astype(PETSc.IntType), comm=self.comm)
        matrix = full.createSubMatrix(free, free) if self._supports else full
        # Element matrices are symmetric up to rounding; a + b = b + a makes their mean exactly so.
        transpose = matrix.transpose(PETSc.Mat())
        matrix.axpy(1.0, transpose, structure=PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        matrix.scale(0.5)
        return matrix

    def load(self) -> Any:
        """Forces of the pressures, PETSc vector (free), N."""
        return self._load

    @cached_property
    def _load(self) -> Any:
        free = self.expansion.createVecRight()
        if self._pressures:
            pressures = [(p, self._surface_tags[p.surface]) for p in self._pressures]
            full = assemble_vector(pressure_form(self._space, pressures, self._facet_tags))
            full.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
            self.expansion.multTranspose(full, free)
        return free

    def volume_sample(self, subdivisions: int) -> VolumeSample:
        """Sample of the whole body, each cell divided so many times a direction; on every rank.

        Raises
        ------
        InputError
            When subdivisions is less than 1.
        """
        return sample_volume(self._space, subdivisions)


def _without_zeros(matrix: Any) -> Any:
    """Copy of an AIJ matrix without stored zeros, two thirds of a mass matrix in 3D."""
    indptr, indices, values = matrix.getValuesCSR()
    rows = csr_array((values, indices, indptr), shape=(len(indptr) - 1, matrix.getSize()[1]))
    rows.eliminate_zeros()
    return PETSc.Mat().createAIJ(
        matrix.getSizes(), csr=(rows.indptr, rows.indices, rows.data), comm=matrix.comm
    )
