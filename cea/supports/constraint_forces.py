"""Forces of the constraints of a body, and the part of each of its supports.

A support acts along the directions that it holds, and along no other. At a dof where supports hold
single directions let V_s be the span of those of support s; the force r there is

    r = sum_s f_s,    f_s in V_s,    sum_s |f_s|^2 least,    f_s = P_s S^+ r,    S = sum_s P_s

with P_s the orthogonal projector on V_s. Where the V_s are independent there is one such sum; where
they are not, a direction that two supports hold is shared evenly. A projected constraint, a row of
C u = c, has a multiplier l of its own and the force C^T l over many dofs. It is solved for the
direction t at its anchor, which no single direction there has a part in:

    (C T)^T l = T^T r.

A row belongs to the supports whose faces it is the integral over, to each with its part of the
integral. Rows whose anchor was held already were dropped and bear nothing: the support that holds
the anchor does.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from cea.arrays import Floats, Ints
from cea.supports.directions import Directions, orthonormal


@dataclass(frozen=True)
class RowForces:
    """Forces of projected constraints."""

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
    """How the forces of the constraints of a body are divided among its supports."""

    # orthonormal rows that single directions span at each of the m dofs with a constraint, zero
    # beyond their number, shape (m, dim, dim)
    span: Floats
    # dof, from 0 to m - 1, and support of each space V_s, shape (n,)
    owner: Ints
    support: Ints
    projector: Floats  # P_s, shape (n, dim, dim)
    rows: RowForces | None = None  # forces of projected constraints; None without any

    @classmethod
    def of(
        cls, held: Directions, owner: Ints, taken: Floats, slot: Ints, rows: RowForces | None
    ) -> "ConstraintForces":
        """The division where single directions are held."""
        count, dim = taken.shape[:2]
        number = np.bincount(owner[slot >= 0], minlength=count)
        span = np.where(np.arange(dim)[:, None] < number[:, None, None], taken, 0.0)
        # Directions that depend on others are held as far as the others span them.
        along = np.einsum("nki,ni->nk", span[owner], held.direction)
        direction = np.einsum("nk,nki->ni", along, span[owner])
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        spaces, space = np.unique(
            np.column_stack([owner, held.supports]), axis=0, return_inverse=True
        )
        basis = orthonormal(space.ravel(), direction, len(spaces))[0]
        projector = np.einsum("nki,nkj->nij", basis, basis)
        return cls(span, spaces[:, 0], spaces[:, 1], projector, rows)

    def split(self, force: Floats, supports: int) -> Floats:
        """Forces of each support (N), shape (supports, m, dim)."""
        parts = np.zeros((supports, *force.shape))
        if self.rows is not None:
            for support, part in self.rows.split(force).items():
                parts[support] += part
        rest = force - parts.sum(axis=0)
        empty = np.einsum("nki,nki->nk", self.span, self.span) < 0.5
        total = np.zeros((len(force), *self.span.shape[1:]))
        np.add.at(total, self.owner, self.projector)
        total = np.einsum("nki,nij,nlj->nkl", self.span, total, self.span)
        total += empty[:, :, None] * np.eye(self.span.shape[1])
        along = np.einsum("nki,ni->nk", self.span, rest)
        solved = np.linalg.solve(total, along[..., None])[..., 0]
        shared = np.einsum("nki,nk->ni", self.span, solved)
        own = np.einsum("nij,nj->ni", self.projector, shared[self.owner])
        np.add.at(parts, (self.support, self.owner), own)
        return parts
