"""What a body must offer, however it is discretised; its surfaces in :mod:`cea.surface`.

A body has scalar basis functions numbered 0 .. ``num_scalar_dofs`` - 1 over all ranks. Its *full*
displacement vector holds component c of scalar dof i at ``dim * i + c``; the *free* vector is what
remains when supports are removed, and ``expansion`` (full x free) goes from one to the other.
"""

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.material import IsotropicMaterial
from cea.rotation import Rotation
from cea.surface import Surface
from cea.volume import VolumeCells, VolumeSample


class Body(Protocol):
    """An elastic body: matrices without its supports' dofs, loads, named surfaces."""

    @property
    def name(self) -> str:
        """Name of the body."""
        ...

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""
        ...

    @property
    def comm(self) -> Any:
        """MPI communicator (mpi4py)."""
        ...

    @property
    def material(self) -> IsotropicMaterial:
        """Its material."""
        ...

    @property
    def num_scalar_dofs(self) -> int:
        """Scalar basis functions over all ranks."""
        ...

    @property
    def surfaces(self) -> Mapping[str, Surface]:
        """Named surfaces."""
        ...

    @property
    def expansion(self) -> Any:
        """PETSc AIJ matrix (full x free): displacement of every dof from the free ones."""
        ...

    def stiffness(self) -> Any:
        """Elastic stiffness with springs, PETSc AIJ (free x free), symmetric, N/m."""
        ...

    def spring_stiffness(self) -> Any | None:
        """What springs are of the stiffness, PETSc AIJ (free x free), N/m; None without any."""
        ...

    def mass(self) -> Any:
        """Consistent mass, PETSc AIJ (free x free), symmetric positive definite, kg.

        Raises
        ------
        InputError
            When the material has no density.
        """
        ...

    @property
    def dof_positions(self) -> Floats | None:
        """Coefficients of the position x in the trial space (m), on every rank; collective.

        Shape (num_scalar_dofs, dim); None where x does not lie in it, so that a rotation does not.
        """
        ...

    @property
    def node_positions(self) -> Floats | None:
        """Where the scalar dofs of this rank lie (m), shape (n_local, dim).

        None where no part of the body can be assembled alone.
        """
        ...

    def part(self, nodes: NDArray[np.bool_]) -> tuple[Any, Any]:
        """Stiffness without springs (N/m) and mass (kg) of a part alone, of free ends elsewhere.

        PETSc AIJ (free x free), symmetric; what is left of those of the body without it is positive
        semidefinite.

        Parameters
        ----------
        nodes
            Which scalar dofs of this rank all cells of the part are among, shape (n_local,).

        Raises
        ------
        InputError
            When the material has no density, or no part can be assembled alone.
        """
        ...

    def gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s (:mod:`cea.rotation`), PETSc AIJ (free x free), kg, skew.

        Raises
        ------
        InputError
            When the material has no density.
        """
        ...

    def convective_stiffness(self, rotation: Rotation) -> Any:
        """Z of a rotation (:mod:`cea.rotation`), PETSc AIJ (free x free), kg, symmetric.

        Raises
        ------
        InputError
            When the material has no density.
        """
        ...

    @property
    def prescribed(self) -> Any | None:
        """Displacement of all dofs that supports prescribe (m), PETSc vector (full).

        None where they hold all at zero. The displacement is this and what the free dofs add.
        """
        ...

    def full_stiffness(self) -> Any:
        """Elastic stiffness with springs of all dofs, held ones too, PETSc AIJ (full x full), N/m.

        Made anew at each call.
        """
        ...

    def full_spring_stiffness(self) -> Any | None:
        """What springs are of that, PETSc AIJ (full x full), N/m; None without any."""
        ...

    def full_gyroscopic(self, rotation: Rotation) -> Any:
        """Y of a rotation at 1 rad/s of all dofs, PETSc AIJ (full x full), kg; made anew."""
        ...

    def full_convective_stiffness(self, rotation: Rotation) -> Any:
        """Z of a rotation of all dofs, PETSc AIJ (full x full), kg; made anew."""
        ...

    def support_forces(self, force: Floats) -> tuple[Ints, Floats]:
        """Forces of each support, along the directions that it holds and no other.

        Parameters
        ----------
        force
            The sum of all of them on all dofs (N), shape (num_scalar_dofs, dim).

        Returns
        -------
        tuple
            The scalar dofs that supports hold, shape (m,), and the forces of each support on the
            body there (N), shape (supports, m, dim); their sum is the given one at these dofs where
            the free dofs are in equilibrium.
        """
        ...

    def load(self) -> Any:
        """Forces of pressures, on surfaces and on every part, PETSc vector (free), N.

        With those of prescribed displacements, - Z^T K u_D (:mod:`cea.supports.prescribed`).
        """
        ...

    def full_load(self) -> Any:
        """The same on all dofs, without those of prescribed displacements, PETSc vector (full)."""
        ...

    def geometric_stiffness(self, displacement: Floats) -> Any:
        """Stiffness that stresses make: int sigma_ij d_i u . d_j v, PETSc AIJ (free x free), N/m.

        Symmetric; sigma is the stress of a displacement by the law of the material (Wriggers,
        Nonlinear Finite Element Methods, 2008, sec. 4.2.3).

        Parameters
        ----------
        displacement
            Displacement of all dofs (m), the same on every rank, shape (dim * num_scalar_dofs,).
        """
        ...

    def volume_sample(self, subdivisions: int) -> VolumeSample:
        """Sample of the whole body, each cell or knot span divided so many times a direction.

        Gathered: complete on rank 0.
        """
        ...

    def volume_cells(self) -> VolumeCells:
        """Cells of the whole body with its geometry and trial space as they are.

        Gathered: complete on rank 0.
        """
        ...
