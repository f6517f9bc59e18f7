"""Reactions of a contact whose law is not linear: closures, forces and tangent at any state.

With the closure g = u_n - g_n at points of weight w, the pressure sigma = sigma(g) of the law and
its slope p = d sigma / d g,

    points:   g = G x - g_n,            r = (G - mu T)^T w sigma
    mortar:   g = N E x - N E_0 g_n,    r = (E - mu E_k)^T N^T w sigma,    E = M^-1 B,

where N are the traces psi of side a at the points, M_ij = int psi_i psi_j, and B, B_k those of
:mod:`cea.contact.mortar`: the law meets the projected closure, and the multiplier is the projected
pressure. Where p is uniform this is the mortar contact of a linear law. Open points have p = 0 and
no compliance, so the mortar forces cannot be kept as unknowns.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.linalg import cho_solve, lapack
from scipy.sparse import csr_array, diags_array, vstack

from cea.arrays import Floats, Ints
from cea.contact.interface import Interface
from cea.contact.mortar import INDEPENDENT, MortarProjection, everywhere
from cea.matrices import (
    destroy,
    distributed,
    gather,
    local_part,
    product,
    symmetric_product,
)
from cea.petsc import PETSc


class Reactions(Protocol):
    """What a contact does at any state of its bodies; every call is collective."""

    def approach(self, x: Any) -> Floats:
        """What the motion x (PETSc vector) closes of the gap at all points (m), on every rank."""
        ...

    def met(self, gap: Floats) -> Floats:
        """A gap given at all points (m) as the law meets it, shape (n,)."""
        ...

    def forces(self, pressure: Floats, *, friction: bool) -> Any:
        """Forces (N) that a pressure at all points (N/m^2) puts against the motion, PETSc vector.

        Parameters
        ----------
        pressure
            Contact pressure, shape (n,).
        friction
            Whether with friction.
        """
        ...

    def tangent(self, slope: Floats) -> tuple[Any, Any | None]:
        """K_n and K_f, PETSc AIJ (N/m), of a slope p at all points (N/m^3); without slip no K_f."""
        ...


@dataclass(frozen=True)
class PointReactions:
    """Reactions at points that stand for themselves.

    Parameters
    ----------
    interface
        The points.
    gap
        G, PETSc AIJ (points x free dofs).
    slip
        diag(mu) T, PETSc AIJ; None without friction.
    """

    interface: Interface
    gap: Any
    slip: Any | None

    def approach(self, x: Any) -> Floats:
        """G x, shape (n,)."""
        closed = self.gap.createVecLeft()
        self.gap.mult(x, closed)
        values = gather(closed)
        destroy(closed)
        return values

    def met(self, gap: Floats) -> Floats:
        """The gap itself."""
        return gap

    def forces(self, pressure: Floats, *, friction: bool) -> Any:
        """(G - mu T)^T w sigma, PETSc vector."""
        weighted = self._weighted(pressure)
        force = self.gap.createVecRight()
        self.gap.multTranspose(weighted, force)
        if friction and self.slip is not None:
            rubbing = self.gap.createVecRight()
            self.slip.multTranspose(weighted, rubbing)
            force.axpy(-1.0, rubbing)
            destroy(rubbing)
        destroy(weighted)
        return force

    def tangent(self, slope: Floats) -> tuple[Any, Any | None]:
        """G^T D G and T^T diag(mu) D G, D = diag(w p)."""
        weight = self._weighted(slope)
        normal = symmetric_product(self.gap, weight)
        friction = product(self.slip, self.gap, weight) if self.slip is not None else None
        destroy(weight)
        return normal, friction

    def _weighted(self, values: Floats) -> Any:
        weighted = self.gap.createVecLeft()
        weighted.array[:] = self.interface.local_points.weight * values[self.interface.rows]
        return weighted


class MortarReactions:
    """Reactions where the law meets the closure projected on the traces of side a.

    The same on every rank: there are as many coefficients as side a has trace functions.

    Parameters
    ----------
    projection
        Projection on the traces of side a.
    gap
        B, PETSc AIJ (traces x free dofs).
    slip
        B_k, PETSc AIJ; None without friction.
    """

    def __init__(self, projection: MortarProjection, gap: Any, slip: Any | None) -> None:
        self._gap = gap
        interface = projection.interface
        self._weight = interface.points.weight
        gram = projection.compliance(np.ones(len(self._weight)))
        M = everywhere(gram).toarray()
        destroy(gram)
        self._scale = 1 / np.sqrt(np.diag(M))
        factor, order, rank, _ = lapack.dpstrf(
            self._scale[:, None] * M * self._scale, tol=INDEPENDENT
        )
        kept = order[:rank] - 1
        self._scale = self._scale[kept]
        self._factor = np.triu(factor[:rank, :rank])
        traces = interface.comm.allgather(local_part(projection.traces))
        self._traces = csr_array(csr_array(vstack(traces))[:, kept])
        wholes = [everywhere(each)[kept] for each in (gap, slip) if each is not None]
        self._columns = np.unique(np.concatenate([w.indices[w.data != 0] for w in wholes]))
        self._closing, *rubbing = self._projected(wholes)
        self._slipping = rubbing[0] if rubbing else None

    def _projected(self, integrals: Sequence[csr_array]) -> list[Floats]:
        """E = M^-1 B of each B, on the columns that any of them touches."""
        return [self._solve(each[:, self._columns].toarray()) for each in integrals]

    def _solve(self, right: Floats) -> Floats:
        """M^-1 times a block."""
        scale = self._scale[:, None]
        return scale * cho_solve((self._factor, False), scale * right)

    def approach(self, x: Any) -> Floats:
        """N E x, shape (n,)."""
        return self._traces @ (self._closing @ gather(x)[self._columns])

    def met(self, gap: Floats) -> Floats:
        """The gap projected on the traces, shape (n,)."""
        integrals = self._traces.T @ (self._weight * gap)
        return self._traces @ self._solve(integrals[:, None])[:, 0]

    def forces(self, pressure: Floats, *, friction: bool) -> Any:
        """(E - mu E_k)^T N^T w sigma, PETSc vector."""
        integrals = self._traces.T @ (self._weight * pressure)
        values = self._closing.T @ integrals
        if friction and self._slipping is not None:
            values -= self._slipping.T @ integrals
        force = self._gap.createVecRight()
        mine, start = self._mine()
        force.array[self._columns[mine] - start] = values[mine]
        return force

    def tangent(self, slope: Floats) -> tuple[Any, Any | None]:
        """E^T (N^T D N) E and E_k^T (N^T D N) E, full on the whole interface."""
        inner = self._traces.T @ diags_array(self._weight * slope) @ self._traces
        pushed = inner @ self._closing
        normal = self._closing.T @ pushed
        K_n = self._matrix(0.5 * (normal + normal.T))
        K_n.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        if self._slipping is None:
            return K_n, None
        return K_n, self._matrix(self._slipping.T @ pushed)

    def _mine(self) -> tuple[Ints, int]:
        """Which of the columns are unknowns of this rank, and its first unknown."""
        first, last = self._gap.getOwnershipRangeColumn()
        return np.flatnonzero((self._columns >= first) & (self._columns < last)), first

    def _matrix(self, block: Floats) -> Any:
        """A full block on the columns as a matrix on all unknowns, PETSc AIJ."""
        mine, start = self._mine()
        local, total = self._gap.getSizes()[1]
        lengths = np.zeros(local, dtype=np.int64)
        lengths[self._columns[mine] - start] = len(self._columns)
        indptr = np.concatenate([[0], np.cumsum(lengths)])
        indices = np.tile(self._columns, len(mine))
        rows = csr_array((block[mine].ravel(), indices, indptr), shape=(local, total))
        return distributed(rows, self._gap.getSizes()[1], self._gap.comm)
