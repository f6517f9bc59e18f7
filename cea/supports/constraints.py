"""Supports as linear constraints, and the expansion from what they leave free.

A point constraint holds a direction d at one scalar dof i (a node, or a control point):
d . u_i = 0. A projected constraint is a row of coefficients over many dofs, C u = 0, anchored at
the dof and the direction it is to be solved for. At each dof an orthonormal frame is split into
free directions B, directions T solved for, and held ones, so that u = B v + T s and

    C T s + C B v = 0,    u = (B - T (C T)^-1 C B) v = Z v.

Where supports prescribe values, d . u_i = g and C u = c, a displacement u_D is added to that, zero
but at held dofs, and the equilibrium of the free dofs is Z^T K Z v = Z^T F - Z^T K u_D.

They are eliminated in :mod:`cea.supports.elimination`, and their forces divided among the
supports here. Every rank holds all constraints: there are as many as a surface has dofs.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import splu

from cea.arrays import Floats, Ints
from cea.matrices import destroy, distributed
from cea.petsc import PETSc
from cea.supports.directions import Directions, orthonormal

_RANK = 1e-10  # eigenvalue of a sum of projectors, relative to the largest, that is none


@dataclass(frozen=True)
class RowForces:
    """Forces of projected constraints, rows of C u = c, each with a multiplier of its own.

    A row is solved for the direction t at its anchor, which no single direction there has a part
    in: (C T)^T l = T^T r. It belongs to the supports whose faces it is the integral over, to each
    with its part of the integral.
    """

    # T: displacement of the dofs along the anchors of the rows, shape (dim * m, rows)
    anchors: csr_array
    # the part of C of each support, shape (rows, dim * m); C is their sum
    shares: Mapping[int, csr_array]

    @property
    def matrix(self) -> csr_array:
        """C, shape (rows, dim * m)."""
        first, *others = self.shares.values()
        return csr_array(sum(others, first))

    def split(self, force: Floats) -> dict[int, Floats]:
        """C_s^T l by support (N), shape (m, dim) each, of the forces at the dofs, (m, dim)."""
        solved = csr_array(self.matrix @ self.anchors)
        multiplier = splu(solved.T.tocsc()).solve(self.anchors.T @ force.ravel())
        return {
            support: (rows.T @ multiplier).reshape(force.shape)
            for support, rows in self.shares.items()
        }


@dataclass(frozen=True)
class ConstraintForces:
    """How the forces of the constraints of a body are divided among its supports.

    At a dof where supports hold single directions let V_s be the span of those of support s, P_s
    the projector on it and S = sum_s P_s; of the force r there support s has f_s = P_s S^+ r, the
    sum of least squares. A direction that two supports hold is shared evenly.
    """

    # dof, from 0 to m - 1, and support of each space V_s, shape (n,)
    owner: Ints
    support: Ints
    projector: Floats  # P_s, shape (n, dim, dim)
    rows: RowForces | None = None  # forces of projected constraints; None without any

    @classmethod
    def of(
        cls, held: Directions, owner: Ints, taken: Floats, slot: Ints, rows: RowForces | None
    ) -> "ConstraintForces":
        """The division where single directions are held, of which taken ones are independent."""
        count, dim = taken.shape[:2]
        number = np.bincount(owner[slot >= 0], minlength=count)
        span = np.where(np.arange(dim)[:, None] < number[:, None, None], taken, 0.0)
        # Directions that depend on others are held as far as the others span them.
        along = np.einsum("nki,ni->nk", span[owner], held.direction)
        direction = np.einsum("nk,nki->ni", along, span[owner])
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        pairs = np.column_stack([owner, held.support])
        spaces, space = np.unique(pairs, axis=0, return_inverse=True)
        basis = orthonormal(space.ravel(), direction, len(spaces))[0]
        projector = np.einsum("nki,nkj->nij", basis, basis)
        return cls(spaces[:, 0], spaces[:, 1], projector, rows)

    def split(self, force: Floats, supports: int) -> Floats:
        """Forces of each support (N), shape (supports, m, dim), of those at the dofs, (m, dim)."""
        parts = np.zeros((supports, *force.shape))
        if self.rows is not None:
            for support, part in self.rows.split(force).items():
                parts[support] += part
        total = np.zeros((*force.shape, force.shape[1]))
        np.add.at(total, self.owner, self.projector)
        rest = force - parts.sum(axis=0)
        shared = np.linalg.pinv(total, rcond=_RANK, hermitian=True) @ rest[:, :, None]
        own = (self.projector @ shared[self.owner])[:, :, 0]
        np.add.at(parts, (self.support, self.owner), own)
        return parts


@dataclass(frozen=True)
class Constraints:
    """What the supports of a body leave free."""

    dim: int  # dimension of space
    num_scalar_dofs: int  # scalar dofs of the body
    dofs: Ints  # scalar dofs with a constraint, rising, shape (m,)
    removed: Ints  # unknowns lost at each of them, shape (m,)
    # their displacement components from the free unknowns, shape (dim * m, free unknowns)
    rows: csr_array
    frame: csr_array  # the same without what dependent dofs add: B at each of them
    forces: ConstraintForces  # how the forces of the constraints are divided among the supports
    # displacement components of theirs that are prescribed (m), shape (dim * m,); None where all
    # is held at zero
    prescribed: Floats | None = None

    @cached_property
    def selects(self) -> bool:
        """True when free unknowns are plain displacement components: Z picks some of them."""
        alone = len(np.unique(self.rows.indices)) == self.rows.nnz
        return bool(alone and np.all(self.rows.data == 1.0))

    def _first_free(self, dofs: Ints) -> Ints:
        return first_free_at(self.dim, self.dofs, self.removed, dofs)

    def expansion(self, first: int, last: int, comm: Any) -> Any:
        """Z, PETSc AIJ (full x free)."""
        local = self._local(self.rows, first, last)
        starts, stops = self._first_free(np.array([first, last]))
        return distributed(local, (int(stops - starts), local.shape[1]), comm)

    def frames(self, first: int, last: int) -> csr_array:
        """B of the scalar dofs of a rank: their displacement from the free unknowns at them.

        B^T B = I, and B^T u gives the free unknowns of a displacement u that the supports admit.
        """
        starts, stops = self._first_free(np.array([first, last]))
        return csr_array(self._local(self.frame, first, last)[:, int(starts) : int(stops)])

    def _local(self, rows: csr_array, first: int, last: int) -> csr_array:
        """Displacement of the scalar dofs of a rank from all free unknowns."""
        dim = self.dim
        held = slice(*np.searchsorted(self.dofs, [first, last]))
        plain = np.setdiff1d(np.arange(first, last), self.dofs[held], assume_unique=True)
        component = np.arange(dim)
        free = coo_array(rows[dim * held.start : dim * held.stop])
        of_held = components(self.dofs[held] - first, dim)
        entries = (
            np.concatenate([np.ones(dim * len(plain)), free.data]),
            (
                np.concatenate([components(plain - first, dim), of_held[free.row]]),
                np.concatenate(
                    [(self._first_free(plain)[:, None] + component).ravel(), free.col],
                ),
            ),
        )
        size = dim * (last - first)
        return csr_array(coo_array(entries, shape=(size, rows.shape[1])))

    def prescribed_displacement(self, first: int, last: int, expansion: Any) -> Any | None:
        """u_D, PETSc vector (full), m; None where all is held at zero."""
        if self.prescribed is None:
            return None
        held = slice(*np.searchsorted(self.dofs, [first, last]))
        vector = expansion.createVecLeft()
        part = self.prescribed[self.dim * held.start : self.dim * held.stop]
        vector.array[components(self.dofs[held] - first, self.dim)] = part
        return vector

    def restrict(self, matrix: Any, expansion: Any) -> Any:
        """Z^T A Z of a symmetric matrix; a product only where Z picks no components."""
        if not self.selects:
            # Ten times faster than PtAP of serial AIJ where dependent dofs have long rows.
            half = matrix.matMult(expansion)
            product = expansion.transposeMatMult(half)
            destroy(half)
            return product
        first, last = expansion.getOwnershipRange()
        picked = np.ones(self.dim * self.num_scalar_dofs, dtype=bool)
        picked[components(self.dofs, self.dim)] = np.diff(self.rows.indptr) > 0
        chosen = (first + np.flatnonzero(picked[first:last])).astype(PETSc.IntType)
        free = PETSc.IS().createGeneral(chosen, comm=matrix.comm)
        return matrix.createSubMatrix(free, free)


def first_free_at(dim: int, held: Ints, removed: Ints, dofs: Ints) -> Ints:
    """Number of the first free unknown at scalar dofs, or of the next one."""
    before = np.concatenate([[0], np.cumsum(removed)])
    return dim * dofs - before[np.searchsorted(held, dofs)]


def components(dofs: Ints, dim: int) -> Ints:
    """Full dofs of scalar dofs."""
    return (dim * dofs[:, None] + np.arange(dim)).ravel()
