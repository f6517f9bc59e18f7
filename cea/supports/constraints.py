"""Supports as linear constraints, and the expansion from the free unknowns.

A point constraint fixes a direction d at one scalar dof i (a node, or a control point):
d . u_i = 0. A projected constraint is a row of coefficients over many dofs, C u = 0, assigned to
the dof and direction for which it is solved. At each dof an orthonormal frame is split into free
directions B, directions T that are solved for, and fixed ones, so that u = B v + T s and
    C T s + C B v = 0,    u = (B - T (C T)^-1 C B) v = Z v.

For prescribed values, d . u_i = g and C u = c, a displacement u_D is added, which is zero except at
constrained dofs, and the equilibrium of the free dofs is Z^T K Z v = Z^T F - Z^T K u_D.

:mod:`cea.supports.elimination` eliminates them. Every rank holds all constraints, as many as
surfaces have dofs.

The force of constraints A u = b is A^T l with the multipliers l of least norm: supports that fix
the same direction share its force equally. A projected row is the sum of the rows of the supports
whose faces it integrates over, and its force is divided accordingly.
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

_ROUNDING = 1e-16  # relative tolerance of the multipliers


@dataclass(frozen=True)
class Constraints:
    """Constraints of the supports of a body, and the expansion from its free unknowns."""

    dim: int  # dimension of space
    dofs: Ints  # constrained scalar dofs, increasing, shape (m,)
    removed: Ints  # number of unknowns eliminated at each of them, shape (m,)
    # their displacement components from the free unknowns, shape (dim * m, free unknowns)
    rows: csr_array
    frame: csr_array  # the same without dependent dofs: B at each of them
    # part of A of each support at these dofs, by its number, shape (constraints, dim * m)
    shares: Mapping[int, csr_array]
    # prescribed displacement components at these dofs (m), shape (dim * m,); None if all
    # are zero
    prescribed: Floats | None = None

    def split(self, force: Floats, supports: int) -> Floats:
        """Split constraint forces at the dofs (N), (m, dim), by support, (supports, m, dim)."""
        parts = np.zeros((supports, *force.shape))
        if self.shares:
            every = csr_array(sum(self.shares.values()))
            exactly = {"atol": _ROUNDING, "btol": _ROUNDING, "conlim": 0.0}
            multipliers = lsqr(every.T, force.ravel(), **exactly)[0]
            for support, rows in self.shares.items():
                parts[support] = (rows.T @ multipliers).reshape(force.shape)
        return parts

    @cached_property
    def selects(self) -> bool:
        """Whether free unknowns are displacement components, so that Z selects some of them."""
        alone = len(np.unique(self.rows.indices)) == self.rows.nnz
        return bool(alone and np.all(self.rows.data == 1.0))

    def first_free(self, dofs: Ints) -> Ints:
        """Return the number of the first free unknown at scalar dofs, or after them."""
        return first_free_at(self.dim, self.dofs, self.removed, dofs)

    def expansion(self, first: int, last: int, comm: Any) -> Any:
        """Return Z, PETSc AIJ (full x free)."""
        local = self._local(self.rows, first, last)
        starts, stops = self.first_free(np.array([first, last]))
        return distributed(local, (int(stops - starts), local.shape[1]), comm)

    def frames(self, first: int, last: int) -> csr_array:
        """Return B of the scalar dofs of a rank: their displacement from their free unknowns.

        B^T B = I, and B^T u gives the free unknowns of an admissible displacement u.
        """
        own = slice(*self.first_free(np.array([first, last])))
        return csr_array(self._local(self.frame, first, last)[:, own])

    def _local(self, rows: csr_array, first: int, last: int) -> csr_array:
        """Return the displacement of the scalar dofs of a rank from all free unknowns."""
        held = self._held(first, last)
        plain = np.setdiff1d(np.arange(first, last), self.dofs[held], assume_unique=True)
        column = (self.first_free(plain)[:, None] + np.arange(self.dim)).ravel()
        entries = (np.ones(len(column)), column, np.arange(len(column) + 1))
        identity = csr_array(entries, shape=(len(column), rows.shape[1]))
        of_held = rows[self.dim * held.start : self.dim * held.stop]
        order = np.argsort(components(np.concatenate([plain, self.dofs[held]]), self.dim))
        return csr_array(vstack([identity, of_held], format="csr")[order])

    def _held(self, first: int, last: int) -> slice:
        """Return the range of constrained scalar dofs that belongs to a rank."""
        return slice(*np.searchsorted(self.dofs, [first, last]))

    def prescribed_displacement(self, first: int, last: int) -> Floats | None:
        """Return u_D of the scalar dofs of a rank (m), full; None if it is zero."""
        if self.prescribed is None:
            return None
        held, whole = self._held(first, last), np.zeros(self.dim * (last - first))
        part = self.prescribed[self.dim * held.start : self.dim * held.stop]
        whole[components(self.dofs[held] - first, self.dim)] = part
        return whole


def first_free_at(dim: int, held: Ints, removed: Ints, dofs: Ints) -> Ints:
    """Return the number of the first free unknown at scalar dofs, or after them."""
    before = np.concatenate([[0], np.cumsum(removed)])
    return dim * dofs - before[np.searchsorted(held, dofs)]


def components(dofs: Ints, dim: int) -> Ints:
    """Return the full dofs of scalar dofs."""
    return (dim * dofs[:, None] + np.arange(dim)).ravel()
