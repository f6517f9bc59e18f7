"""Interface of the space of a body, and its cells; surfaces are in :mod:`cea.surface`.

A space has scalar basis functions numbered 0 .. ``num_scalar_dofs`` - 1 over all ranks. A *full*
displacement vector holds component c of function i at ``dim * i + c``.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints
from cea.material import Elasticity
from cea.mesh import lattice
from cea.motion import Rotation
from cea.supports.boundary import Support
from cea.supports.constraints import Constraints
from cea.surface import Surface


@dataclass(frozen=True)
class VolumeCells:
    """Cells of a body with exact geometry and displacement, for visualisation programs.

    They are Lagrange elements on equally spaced nodes, or rational Bezier elements of knot spans.
    Both have one point for each (i, j, k) of a lattice: 0 <= i, j, k <= degree in boxes,
    i + j + k <= degree in simplices. Lagrange elements interpolate the values at their points;
    points and values of Bezier elements are rational Bezier coefficients.
    """

    kind: Literal["lagrange", "bezier"]
    simplex: bool  # whether cells are triangles or tetrahedra
    degree: int  # the same in every direction: lower degrees are elevated
    points: Floats  # positions (m), shape (n, dim)
    weights: Floats  # rational weights of the points, shape (n,); 1 for Lagrange elements
    # points of each right-handed cell in C order of the lattice, shape (n_cells, points of a cell)
    cells: Ints
    values: csr_array  # coefficients there of the scalar basis functions, (n, num_scalar_dofs)

    def straight(self) -> "VolumeCells":
        """Return straight cells through the corners of these cells, with the same fields there."""
        dim, simplex = self.points.shape[1], self.simplex
        places = lattice(dim, self.degree, simplex).tolist()
        corners = (self.degree * lattice(dim, 1, simplex)).tolist()
        at = [places.index(corner) for corner in corners]
        used, cells = np.unique(self.cells[:, at], return_inverse=True)
        points, values = self.points[used], csr_array(self.values[used])
        cells = cells.reshape(-1, len(at))
        return VolumeCells("lagrange", simplex, 1, points, np.ones(len(used)), cells, values)


type Density = float | Callable[[Floats], Floats]
"""Density (kg/m^3), or a function that returns it at positions (m), (dim, n) to (n,)."""


class Space(Protocol):
    """Discrete displacement space of a body: the interface that a backend implements.

    Matrices are PETSc AIJ of all dofs (full x full), owned by the caller; making one is
    collective. Symmetric and skew matrices are so to the last bit.
    """

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""

    @property
    def comm(self) -> Any:
        """MPI communicator (mpi4py)."""

    @property
    def ranges(self) -> Ints:
        """First scalar dof of each rank, and the end of the last, shape (ranks + 1,)."""

    @property
    def surfaces(self) -> Mapping[str, Surface]:
        """Named surfaces, the same on every rank."""

    def constrain(self, supports: Sequence[Support], field: str) -> Constraints:
        """Return the constraints of supports; ``field`` is their name in messages."""

    def stiffness(self, elasticity: Elasticity) -> Any:
        """Return the elastic stiffness (N/m), symmetric."""

    def mass(self, rho: Density) -> Any:
        """Return the consistent mass at a density (kg/m^3), symmetric, block diagonal, kg."""

    def gyroscopic(self, rho: float, rotation: Rotation) -> Any:
        """Return Y at 1 rad/s (:mod:`cea.motion`) at a density (kg/m^3), skew, kg."""

    def convective(self, rho: float, rotation: Rotation) -> Any:
        """Return Z of :mod:`cea.motion` at a density (kg/m^3), symmetric, kg."""

    def geometric_stiffness(self, elasticity: Elasticity, displacement: Floats) -> Any:
        """Return int sigma_ij d_i u . d_j v with the stress of a displacement, symmetric, N/m.

        The displacement of all dofs (m) is the same on every rank, (dim * num_scalar_dofs,)
        (Wriggers, Nonlinear Finite Element Methods, 2008, sec. 4.2.3).
        """

    @property
    def dof_positions(self) -> Floats | None:
        """Coefficients of the position x in the space (m), on every rank; collective.

        Shape (num_scalar_dofs, dim); None if x, and hence a rigid rotation, is not in the space.
        """

    def prolongation(self, coarse: Any) -> csr_array:
        """Return the functions of a coarser space of the same backend, body and ranks in this one.

        The coefficients of all coarse functions on the scalar dofs of this rank, shape
        (n_local, coarse num_scalar_dofs). Raise InputError if the spaces are of different bodies.
        """

    def volume_cells(self) -> VolumeCells:
        """Return the cells of the body with exact geometry and functions; complete on rank 0."""
