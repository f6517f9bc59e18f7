"""Supports as linear constraints, and the expansion from what they leave free.

A point constraint holds a direction d at one scalar dof i (a node, or a control point):
d . u_i = 0. A projected constraint is a row of coefficients over many dofs, C u = 0, anchored at
the dof and the direction it is to be solved for. At each dof an orthonormal frame is split into
free directions B, directions T solved for, and held ones, so that u = B v + T s and

    C T s + C B v = 0,    u = (B - T (C T)^-1 C B) v = Z v.

Where supports prescribe values, d . u_i = g and C u = c, a displacement u_D is added to that, zero
but at held dofs, and the equilibrium of the free dofs is Z^T K Z v = Z^T F - Z^T K u_D.

They are eliminated in :mod:`cea.supports.elimination`. Every rank holds all constraints: there are
as many as a surface has dofs.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from cea.arrays import Floats, Ints
from cea.matrices import distributed
from cea.petsc import PETSc
from cea.supports.constraint_forces import ConstraintForces


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

    @property
    def any(self) -> bool:
        """True when something is held."""
        return len(self.dofs) > 0

    @cached_property
    def selects(self) -> bool:
        """True when free unknowns are plain displacement components: Z picks some of them."""
        alone = len(np.unique(self.rows.indices)) == self.rows.nnz
        return bool(alone and np.all(self.rows.data == 1.0))

    @property
    def kept(self) -> NDArray[np.bool_]:
        """Where Z picks components: which, shape (dim * num_scalar_dofs,)."""
        kept = np.ones(self.dim * self.num_scalar_dofs, dtype=bool)
        kept[components(self.dofs, self.dim)] = np.diff(self.rows.indptr) > 0
        return kept

    def first_free(self, dofs: Ints) -> Ints:
        """Number of the first free unknown at each scalar dof, or of the next one."""
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
        starts, stops = self.first_free(np.array([first, last]))
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
                    [(self.first_free(plain)[:, None] + component).ravel(), free.col],
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

    def support_forces(self, force: Floats, supports: int) -> tuple[Ints, Floats]:
        """As :meth:`cea.body.Body.support_forces`, of so many supports."""
        return self.dofs, self.forces.split(force[self.dofs], supports)

    def restrict(self, matrix: Any, expansion: Any) -> Any:
        """Z^T A Z of a symmetric matrix, symmetric as far as rounding goes.

        Plain components are picked from the matrix; the product is formed only for others.
        """
        if not self.any:
            return matrix
        if not self.selects:
            # Ten times faster than PtAP of serial AIJ where dependent dofs have long rows.
            half = matrix.matMult(expansion)
            product = expansion.transposeMatMult(half)
            half.destroy()
            return product
        first, last = expansion.getOwnershipRange()
        chosen = (first + np.flatnonzero(self.kept[first:last])).astype(PETSc.IntType)
        free = PETSc.IS().createGeneral(chosen, comm=matrix.comm)
        return matrix.createSubMatrix(free, free)


def first_free_at(dim: int, held: Ints, removed: Ints, dofs: Ints) -> Ints:
    """Number of the first free unknown at scalar dofs, or of the next one."""
    before = np.concatenate([[0], np.cumsum(removed)])
    return dim * dofs - before[np.searchsorted(held, dofs)]


def components(dofs: Ints, dim: int) -> Ints:
    """Full dofs of scalar dofs."""
    return (dim * dofs[:, None] + np.arange(dim)).ravel()
