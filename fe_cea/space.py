"""Displacement space of Lagrange elements (dolfinx)."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from dolfinx.fem import functionspace
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints
from cea.body import VolumeCells
from cea.errors import require
from cea.mesh import Mesh
from cea.petsc import MPI
from cea.ranks import agreed
from cea.supports.boundary import Support
from cea.supports.constraints import Constraints
from cea.surface import TrueSurface
from fe_cea.distribution import distribute, lasting_communicator
from fe_cea.matrices import LagrangeMatrices
from fe_cea.prolongation import prolongation
from fe_cea.sampling import check_jacobians, lagrange_cells
from fe_cea.supports import nodal_constraints
from fe_cea.surface import FESurface

_UNKNOWN: Mapping[str, TrueSurface] = MappingProxyType({})


class LagrangeSpace(LagrangeMatrices):
    """Lagrange space of a mesh; implements :class:`cea.body.Space`.

    Parameters
    ----------
    mesh
        Mesh (dolfinx) of triangles, quadrilaterals, tetrahedra or hexahedra.
    facet_tags
        Tags of the boundary facets (dolfinx).
    surface_tags
        Tag of each named surface.
    degree
        Degree of the space, 1 to 4.
    mass_quadrature
        Degree of the quadrature of the mass; by default exact on affine cells. Other programs use
        fewer points: 2 is the degree of the four points of quadratic tetrahedra in CalculiX.
    true_surfaces
        Exact surfaces by name, the same on every rank, which the facets interpolate: initial gaps
        are measured between them. If one is unknown, its distance from the facets is estimated from
        the angles between these, and smaller initial gaps are set to zero.
    field
        Name of the body in messages.

    Raises
    ------
    InputError
        If the degree is not 1 to 4, a quadrature degree is negative, cells are inverted, or a
        surface has no facets.
    """

    def __init__(
        self,
        mesh: Any,
        facet_tags: Any,
        surface_tags: Mapping[str, int],
        *,
        degree: int,
        mass_quadrature: int | None = None,
        true_surfaces: Mapping[str, TrueSurface] = _UNKNOWN,
        field: str = "body",
    ) -> None:
        known = type(degree) is int and 1 <= degree <= 4
        require(known, f"{field}.degree", degree, "1 to 4")
        real = mass_quadrature is None or mass_quadrature >= 0
        require(real, f"{field}.mass_quadrature", mass_quadrature, "0 or more")
        self.comm = lasting_communicator(mesh.comm)
        for surface, tag in surface_tags.items():
            there = self.comm.allreduce(len(facet_tags.find(tag))) > 0
            require(there, f"{field}.surfaces.{surface}", tag, "the tag of at least one facet")
        with agreed(self.comm):
            check_jacobians(mesh, f"{field}.mesh")
        self._field = field
        super().__init__(functionspace(mesh, ("Lagrange", degree)), self.comm, mass_quadrature)
        self._facets = {name: facet_tags.find(tag) for name, tag in surface_tags.items()}
        self._true_surfaces = dict(true_surfaces)

    @classmethod
    def from_mesh(
        cls,
        mesh: Mesh | None,
        *,
        degree: int,
        mass_quadrature: int | None = None,
        true_surfaces: Mapping[str, TrueSurface] = _UNKNOWN,
        field: str = "body",
        comm: Any = MPI.COMM_WORLD,
    ) -> Self:
        """Return the space of a mesh given as plain arrays, with its named surfaces.

        Parameters
        ----------
        mesh
            The mesh; only that of rank 0 is used, other ranks may pass None.
        comm
            Communicator over which to distribute the mesh.
        degree, mass_quadrature, true_surfaces, field
            As for :class:`LagrangeSpace`.

        Raises
        ------
        InputError
            If rank 0 has no mesh, or as for :class:`LagrangeSpace`.
        """
        return cls(
            *distribute(mesh, comm, f"{field}.mesh"),
            degree=degree,
            mass_quadrature=mass_quadrature,
            true_surfaces=true_surfaces,
            field=field,
        )

    @cached_property
    def ranges(self) -> Ints:
        """First scalar dof of each rank, and the end of the last, (ranks + 1,)."""
        ends = self.comm.allgather(self.scalar.dofmap.index_map.local_range[1])
        return np.array([0, *ends])

    @cached_property
    def surfaces(self) -> Mapping[str, FESurface]:
        """Named surfaces."""
        return {
            name: FESurface(name, self.scalar, facets, self._true_surfaces.get(name))
            for name, facets in self._facets.items()
        }

    def constrain(self, supports: Sequence[Support], field: str) -> Constraints:
        """Return the constraints of supports at the nodes."""
        surfaces = self.surfaces if supports else {}
        count = self.scalar.dofmap.index_map.size_global
        return nodal_constraints(self.scalar, surfaces, supports, count, field)

    @property
    def dof_positions(self) -> Floats | None:
        """Nodes (m) on every rank, shape (num_scalar_dofs, dim).

        None if the geometry has a higher degree than the space, which then does not contain x.
        """
        if self.scalar.mesh.geometry.cmaps[0].degree > self.scalar.ufl_element().degree:
            return None
        first, last = self.scalar.dofmap.index_map.local_range
        own = self.scalar.tabulate_dof_coordinates()[: last - first, : self.dim]
        return np.concatenate(self.comm.allgather(own))

    def prolongation(self, coarse: "LagrangeSpace") -> csr_array:
        """Return the functions of a coarser space (:mod:`fe_cea.prolongation`)."""
        return prolongation(coarse.scalar, self.scalar, self.comm, f"{self._field}.mesh")

    def volume_cells(self) -> VolumeCells:
        """Return Lagrange cells of the higher degree of space and geometry; collective.

        They are complete on every rank.
        """
        return lagrange_cells(self.scalar)
