"""Elastic bodies: a discrete space with material, supports, springs and loads.

A space, which a backend implements, has scalar basis functions numbered from 0 over all ranks. A
*full* displacement vector holds component c of function i at ``dim * i + c``. The *free* vector of
a body contains the unknowns that its supports do not remove; the expansion Z (full x free) maps it
to the full vector. A space makes full matrices only; a body adds supports, springs and loads, and
reduces the matrices to Z^T A Z.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, wraps
from itertools import permutations
from typing import Any, Literal, Protocol

import numpy as np
from scipy.sparse import csr_array, diags_array, kron

from cea.arrays import Floats, Ints
from cea.material import Elasticity, Material
from cea.matrices import (
    applied,
    destroy,
    distributed,
    local_part,
    scaled_total,
    side_by_side,
    symmetrised,
    times,
    zeros,
)
from cea.mesh import lattice
from cea.motion import Rotation
from cea.petsc import PETSc
from cea.supports.boundary import Force, Pressure, Spring, Support, check_surface
from cea.supports.constraints import Constraints
from cea.surface import Surface

_MORE_POINTS = 4
"""Gauss points per direction beyond those for polynomials: rational functions converge fast."""
_ROUNDING = 1e-6
"""Relative norm of the skew part of the stiffness of pressures below which it is attributed to
rounding and quadrature."""


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


def _kept(make: Callable[["Body"], Any]) -> Callable[["Body"], Any]:
    """Cache the result of a method of a body."""

    @wraps(make)
    def found(body: "Body") -> Any:
        made, name = vars(body), f"_{make.__name__}"
        if name not in made:
            made[name] = make(body)
        return made[name]

    return found


@dataclass(frozen=True, eq=False)
class Body:
    """Elastic body: matrices of the free dofs, loads, named surfaces.

    Matrices are made on first use, which is collective; stiffness, mass and load are cached.

    Parameters
    ----------
    name
        Name of the body.
    space
        Discretisation.
    material
        Material.
    supports, springs, pressures, forces
        Supports and loads of the named surfaces; springs are part of the stiffness.
    made_of
        Key of its input data: a scene with the same data reuses the body.

    Raises
    ------
    InputError
        If a surface is unknown, or a component, spring or force does not fit the dimension.

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
    made_of: Any = None

    def __post_init__(self) -> None:
        for kind in ("supports", "springs", "pressures", "forces"):
            items: Sequence[Support | Spring | Pressure | Force] = getattr(self, kind)
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
        """Number of scalar basis functions on all ranks."""
        return int(self.space.ranges[-1])

    @property
    def surfaces(self) -> Mapping[str, Surface]:
        """Named surfaces."""
        return self.space.surfaces

    @property
    def density(self) -> float:
        """Density (kg/m^3); InputError if the material has none."""
        return self.material.density(f"bodies.{self.name}.material")

    @property
    def _own(self) -> tuple[int, int]:
        """First scalar dof of this rank, and of the next."""
        first, last = self.space.ranges[self.comm.rank : self.comm.rank + 2]
        return int(first), int(last)

    @cached_property
    def constraints(self) -> Constraints:
        """Constraints of the supports."""
        return self.space.constrain(self.supports, f"bodies.{self.name}.supports")

    @cached_property
    def expansion(self) -> Any:
        """Z, PETSc AIJ (full x free), which maps free dofs to displacements of all dofs."""
        return self.constraints.expansion(*self._own, self.comm)

    def reduced(self, matrix: Any, sign: float = 1.0) -> Any:
        """Return Z^T A Z, PETSc AIJ (free x free), of a matrix A of all dofs; A is destroyed.

        A and the product are symmetric to the last bit, or skew (``sign`` = -1).
        """
        if not len(self.constraints.dofs):
            return matrix
        Z = self.expansion
        if self.constraints.selects:
            kept = np.flatnonzero(np.diff(local_part(Z).indptr)) + Z.getOwnershipRange()[0]
            own = PETSc.IS().createGeneral(kept.astype(PETSc.IntType), comm=Z.comm)
            free = matrix.createSubMatrix(own, own)
        else:
            # Ten times faster than PtAP of serial AIJ if dependent dofs have long rows.
            half = matrix.matMult(Z)
            free = symmetrised(Z.transposeMatMult(half), sign)
            destroy(half)
        destroy(matrix)
        return free

    @_kept
    def stiffness(self) -> Any:
        """Return the elastic stiffness with springs, PETSc AIJ (free x free), symmetric, N/m."""
        elastic, springs = self.elastic_stiffness(), self.spring_stiffness()
        return elastic if springs is None else scaled_total([(1.0, elastic), (1.0, springs)])

    @_kept
    def elastic_stiffness(self) -> Any:
        """Return the stiffness without springs, PETSc AIJ (free x free), symmetric, N/m."""
        return self.reduced(self.space.stiffness(self.material.elasticity))

    @_kept
    def spring_stiffness(self) -> Any | None:
        """Return the stiffness of springs, PETSc AIJ (free x free), N/m; None without springs."""
        springs = self.full_spring_stiffness()
        return None if springs is None else self.reduced(springs)

    def full_spring_stiffness(self) -> Any | None:
        """Return the stiffness of springs, PETSc AIJ (full x full), N/m; None without springs."""
        if not self.springs:
            return None
        own = slice(*(self.dim * number for number in self._own))
        rows = csr_array(sum(_foundation(self.surfaces[s.surface], s)[own] for s in self.springs))
        return distributed(rows, rows.shape, self.comm)

    @_kept
    def mass(self) -> Any:
        """Return the consistent mass, PETSc AIJ (free x free), symmetric positive definite, kg."""
        return self.reduced(self.space.mass(self.density))

    def gyroscopic(self, rotation: Rotation) -> Any:
        """Return Y at 1 rad/s (:mod:`cea.motion`), PETSc AIJ (free x free), kg, skew."""
        return self.reduced(self.space.gyroscopic(self.density, rotation), sign=-1.0)

    def convective_stiffness(self, rotation: Rotation) -> Any:
        """Return Z of :mod:`cea.motion`, PETSc AIJ (free x free), kg, symmetric."""
        return self.reduced(self.space.convective(self.density, rotation))

    def geometric_stiffness(self, displacement: Floats) -> Any:
        """Return the geometric stiffness of a displacement, PETSc AIJ (free x free), N/m."""
        return self.reduced(self.space.geometric_stiffness(self.material.elasticity, displacement))

    def load_stiffness(self) -> list[tuple[Any, bool]]:
        """Return the stiffness of pressures, which turn with their surfaces (N/m).

        One PETSc AIJ (free x free), symmetric, and a skew one if it is not zero: pressures do work
        on closed paths where the border of their surface moves. Each is followed by whether it is
        symmetric.
        """
        if not self.pressures:
            return []
        own = slice(*(self.dim * number for number in self._own))
        parts = [_stiffness_of_pressure(self.surfaces[p.surface], p)[own] for p in self.pressures]
        rows = csr_array(sum(parts))
        whole = distributed(rows, rows.shape, self.comm)
        size = whole.norm()
        skew = self.reduced(symmetrised(whole.copy(), -1.0), -1.0)
        symmetric = self.reduced(symmetrised(whole))
        if skew.norm() > _ROUNDING * size:
            return [(symmetric, True), (skew, False)]
        destroy(skew)
        return [(symmetric, True)]

    @cached_property
    def prescribed(self) -> Floats | None:
        """u_D, prescribed displacement of the dofs of this rank (m); None if it is zero."""
        return self.constraints.prescribed_displacement(*self._own)

    @_kept
    def load(self) -> Any:
        """Return Z^T (F - K u_D), forces of loads and prescribed displacements, PETSc (free), N."""
        full, free = self.full_load(), self.expansion.createVecRight()
        if self.prescribed is not None:
            elastic = self.space.stiffness(self.material.elasticity)
            for stiffness in (elastic, self.full_spring_stiffness()):
                if stiffness is not None:
                    full -= applied(stiffness, self.prescribed)
                    destroy(stiffness)
        free.array[:] = applied(self.expansion, full, transposed=True)
        return free

    def full_load(self) -> Floats:
        """Return F, the forces of loads on the dofs of this rank (N), full."""
        forces, volume = np.zeros((self.num_scalar_dofs, self.dim)), np.zeros(self.dim)
        loads: list[Pressure | Force] = [*self.pressures, *self.forces]
        for load in loads:
            if load.surface is None:
                volume += load.value
                continue
            surface, q = self.surfaces[load.surface], self.surfaces[load.surface].cells.degree
            # On facets of degree q, function times area normal has degree up to 3 q - 1.
            count = (3 * q + 1) // 2 if isinstance(load, Pressure) else q + 1
            points = surface.gauss_points(count)
            traction = points.weight[:, None] * load.traction(points)
            forces += surface.trace(points.at).T @ traction
        own = forces[slice(*self._own)].ravel()
        if volume.any():
            volumes = self.space.mass(1.0)
            own += applied(volumes, np.tile(volume, len(own) // self.dim))
            destroy(volumes)
        return own


def _foundation(surface: Surface, spring: Spring) -> csr_array:
    """Return the full matrix of a spring: int k_c phi_m phi_n on the diagonal of component c."""
    points = surface.gauss_points(surface.cells.degree + 1)
    scaled = diags_array(np.sqrt(points.weight)) @ surface.trace(points.at)
    return csr_array(kron(scaled.T @ scaled, diags_array(np.asarray(spring.stiffness))))


def _stiffness_of_pressure(surface: Surface, load: Pressure) -> csr_array:
    """Return the full matrix int p v . ((div u) n - (grad u)^T n) of a pressure.

    The area vector n da of a surface that moves by u changes by the term in brackets times da, to
    first order (Nanson's formula; Wriggers, Nonlinear Finite Element Methods, 2008). Derivatives
    along n cancel.
    """
    points = surface.gauss_points(3 * surface.cells.degree // 2 + _MORE_POINTS)
    trace, slopes = surface.trace(points.at), surface.gradient(points.at)
    areas = [diags_array(load.value * points.weight * along) for along in points.normal.T]
    total = csr_array((surface.dim * surface.num_scalar_dofs,) * 2)
    for i, j in permutations(range(surface.dim), 2):
        place = np.zeros((surface.dim, surface.dim))
        place[i, j] = 1.0
        total += kron(trace.T @ (areas[i] @ slopes[j] - areas[j] @ slopes[i]), place)
    return csr_array(total)


def free_operator(operator: csr_array, body: Body) -> Any:
    """Return A Z, PETSc AIJ, for an operator A on full dofs, given by the rows of this rank."""
    full = distributed(operator, body.expansion.getSizes()[0], body.comm)
    free = times(full, body.expansion)
    destroy(full)
    return free


def system_operator(bodies: Mapping[str, Body], parts: Mapping[str, csr_array], rows: int) -> Any:
    """Combine operators on full dofs of bodies to one on the unknowns of the system."""
    blocks = [
        free_operator(parts[name], body)
        if name in parts
        else zeros((rows, PETSc.DETERMINE), body.expansion.getSizes()[1], body.comm)
        for name, body in bodies.items()
    ]
    whole = side_by_side(blocks)
    destroy(*blocks)
    return whole
