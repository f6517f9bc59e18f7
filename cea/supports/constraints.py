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
from scipy.sparse import csr_array, vstack
from scipy.sparse.linalg import splu

from cea.arrays import Floats, Ints
from cea.matrices import distributed
from cea.supports.directions import Directions

_RANK = 1e-10  # eigenvalue of sum_k d_k d_k^T, relative to the largest, that is none


@dataclass(frozen=True)
class ConstraintForces:
    """How the forces of the constraints of a body are divided among its supports.

    At a dof where supports hold single directions d_k the force is r = sum_k a_k d_k with the
    amounts a_k of least squares: a direction that two supports hold is shared evenly.

    A projected constraint, a row of C u = c, has a multiplier l of its own. It is solved for the
    direction t at its anchor, which no single direction there has a part in: (C T)^T l = T^T r. It
    belongs to the supports whose faces it is the integral over, to each with its part C_s of it.
    """

    # dof, from 0 to m - 1, and support of each direction, shape (n,)
    owner: Ints
    support: Ints
    direction: Floats  # d_k, shape (n, dim)
    # T: displacement of the dofs along the anchors of the rows, shape (dim * m, rows)
    anchors: csr_array
    shares: Mapping[int, csr_array]  # C_s by support, shape (rows, dim * m); none without rows

    @classmethod
    def of(
        cls,
        held: Directions,
        owner: Ints,
        taken: Floats,
        slot: Ints,
        anchors: csr_array,
        shares: Mapping[int, csr_array],
    ) -> "ConstraintForces":
        """The division where single directions are held, of which taken ones are independent."""
        count, dim = taken.shape[:2]
        number = np.bincount(owner[slot >= 0], minlength=count)
        span = np.where(np.arange(dim)[:, None] < number[:, None, None], taken, 0.0)
        # Directions that depend on others are held as far as the others span them.
        along = np.einsum("nki,ni->nk", span[owner], held.direction)
        direction = np.einsum("nk,nki->ni", along, span[owner])
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        return cls(owner, held.support, direction, anchors, shares)

    def split(self, force: Floats, supports: int) -> Floats:
        """Forces of each support (N), shape (supports, m, dim), of those at the dofs, (m, dim)."""
        parts = np.zeros((supports, *force.shape))
        if self.shares:
            solved = csr_array(sum(self.shares.values()) @ self.anchors)
            multiplier = splu(solved.T.tocsc()).solve(self.anchors.T @ force.ravel())
            for support, rows in self.shares.items():
                parts[support] = (rows.T @ multiplier).reshape(force.shape)
        total = np.zeros((*force.shape, force.shape[1]))
        np.add.at(total, self.owner, self.direction[:, :, None] * self.direction[:, None])
        rest = force - parts.sum(axis=0)
        shared = np.linalg.pinv(total, rcond=_RANK, hermitian=True) @ rest[:, :, None]
        amounts = np.einsum("ni,ni->n", self.direction, shared[self.owner, :, 0])
        np.add.at(parts, (self.support, self.owner), amounts[:, None] * self.direction)
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

    def first_free(self, dofs: Ints) -> Ints:
        """Number of the first free unknown at scalar dofs, or of the next one."""
        return first_free_at(self.dim, self.dofs, self.removed, dofs)

    def expansion(self, first: int, last: int, comm: Any) -> Any:
        """Z, PETSc AIJ (full x free)."""
        local = self._local(self.rows, first, last)
        starts, stops = self.first_free(np.array([first, last]))
        return distributed(local, (int(stops - starts), local.shape[1]), comm)

    def frames(self, first: int, last: int) -> csr_array:
        """B of the scalar dofs of a rank: their displacement from the free unknowns at them.

        B^T B = I, and B^T u gives the free unknowns of a displacement u that the supports admit.
        """
        own = slice(*self.first_free(np.array([first, last])))
        return csr_array(self._local(self.frame, first, last)[:, own])

    def _local(self, rows: csr_array, first: int, last: int) -> csr_array:
        """Displacement of the scalar dofs of a rank from all free unknowns."""
        held = self._held(first, last)
        plain = np.setdiff1d(np.arange(first, last), self.dofs[held], assume_unique=True)
        column = (self.first_free(plain)[:, None] + np.arange(self.dim)).ravel()
        entries = (np.ones(len(column)), column, np.arange(len(column) + 1))
        identity = csr_array(entries, shape=(len(column), rows.shape[1]))
        of_held = rows[self.dim * held.start : self.dim * held.stop]
        order = np.argsort(components(np.concatenate([plain, self.dofs[held]]), self.dim))
        return csr_array(vstack([identity, of_held], format="csr")[order])

    def _held(self, first: int, last: int) -> slice:
        """Which of the constrained scalar dofs are those of a rank."""
        return slice(*np.searchsorted(self.dofs, [first, last]))

    def prescribed_displacement(self, first: int, last: int) -> Floats | None:
        """u_D of the scalar dofs of a rank (m), full; None where all is held at zero."""
        if self.prescribed is None:
            return None
        held, whole = self._held(first, last), np.zeros(self.dim * (last - first))
        part = self.prescribed[self.dim * held.start : self.dim * held.stop]
        whole[components(self.dofs[held] - first, self.dim)] = part
        return whole


def first_free_at(dim: int, held: Ints, removed: Ints, dofs: Ints) -> Ints:
    """Number of the first free unknown at scalar dofs, or of the next one."""
    before = np.concatenate([[0], np.cumsum(removed)])
    return dim * dofs - before[np.searchsorted(held, dofs)]


def components(dofs: Ints, dim: int) -> Ints:
    """Full dofs of scalar dofs."""
    return (dim * dofs[:, None] + np.arange(dim)).ravel()
