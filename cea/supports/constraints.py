"""Supports as linear constraints, and the expansion from what they leave free.

A point constraint holds a direction d at one scalar dof i (a node, or a control point):
d . u_i = 0. A projected constraint is a row of coefficients over many dofs, C u = 0, anchored at
the dof and the direction it is to be solved for. At each dof an orthonormal frame is split into
free directions B, directions T solved for, and held ones, so that u = B v + T s and

    C T s + C B v = 0,    u = (B - T (C T)^-1 C B) v = Z v.

Where supports prescribe values, d . u_i = g and C u = c, a displacement u_D is added to that, zero
but at held dofs, and the equilibrium of the free dofs is Z^T K Z v = Z^T F - Z^T K u_D.

They are eliminated in :mod:`cea.supports.elimination`. Every rank holds all constraints, as many as
a surface has dofs.

The force of constraints A u = b is A^T l, with the least multipliers l that give it: a direction
that two supports hold is shared evenly. Projected rows are the sum of those of the supports whose
faces they are integrals over, and each bears its part.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array, vstack
from scipy.sparse.linalg import lsqr

from cea.arrays import Floats, Ints
from cea.matrices import distributed

_ROUNDING = 1e-16  # relative error at which multipliers are found


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
    # what each support has of A at these dofs, by its number, shape (constraints, dim * m)
    shares: Mapping[int, csr_array]
    # displacement components of theirs that are prescribed (m), shape (dim * m,); None where all
    # is held at zero
    prescribed: Floats | None = None

    def split(self, force: Floats, supports: int) -> Floats:
        """Forces of each support (N), shape (supports, m, dim), of those at the dofs, (m, dim)."""
        parts = np.zeros((supports, *force.shape))
        if self.shares:
            every = csr_array(sum(self.shares.values()))
            multipliers = lsqr(every.T, force.ravel(), atol=_ROUNDING, btol=_ROUNDING, conlim=0.0)[
                0
            ]
            for support, rows in self.shares.items():
                parts[support] = (rows.T @ multipliers).reshape(force.shape)
        return parts

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
