"""Mortar contact: the gap projected on the trace space of side a.

With psi_i the traces of side a, split at corners, and g the gap, the multiplier
lambda_h = sum_i l_i psi_i satisfies M l = B x, where

    B_i = int psi_i g,   M_ij = int psi_i psi_j / p,   (B_k)_i = int mu psi_i [[u]].k,

and K_n = B^T M^-1 B, K_f = B_k^T M^-1 B. B and M are sparse, K_n and K_f are dense on the whole
interface, so solvers keep l as unknowns (:mod:`cea.contact.saddle`). Bonded sides constrain the
jump along fixed axes, which is continuous over a corner: their traces are not split. Where p is
zero the sides are open: the integrals exclude the open region, and traces that vanish elsewhere
have no multiplier.
"""

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve, lapack
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.linalg import splu, spsolve

from cea.arrays import Floats, Ints
from cea.contact.interface import Interface
from cea.matrices import destroy, distributed, local_part, symmetric_product
from cea.petsc import PETSc

_INDEPENDENT = 1e-15
"""Pivot of M, scaled to unit diagonal, below which a trace is linearly dependent."""
_INDEPENDENT_CUT = 1e-13
"""The same for traces cut by an open region: sparse factors do not detect such dependence."""


def traces_at(interface: Interface, traces: csr_array, closed: NDArray[np.bool_]) -> Any:
    """Return those of given traces that do not vanish at the closed points, PETSc AIJ (points x m).

    ``traces`` are at the points of this rank, ``closed``, shape (n,), at all points; the result is
    zero at the others.
    """
    comm, seen = interface.comm, _at(interface, traces, closed)

    def on(some: Ints) -> Any:
        return distributed(csr_array(seen[:, some]), (PETSc.DECIDE, len(some)), comm)

    touched = _seen_by_any(seen, comm)
    every = on(touched)
    if closed.all():
        return every
    cut = np.isin(touched, _seen_by_any(_at(interface, traces, ~closed), comm))
    gram = mortar_compliance(interface, every, closed.astype(float))
    kept = _independent(everywhere(gram), cut, comm)
    destroy(gram, every)
    return on(touched[kept])


def mortar_compliance(interface: Interface, traces: Any, stiffness: Floats) -> Any:
    """Return M, PETSc AIJ (m x m), symmetric to the last bit, for a stiffness at all points."""
    own, area = stiffness[interface.rows], interface.local_points.weight
    share = np.divide(area, own, out=np.zeros(len(own)), where=own > 0)
    return symmetric_product(traces, share)


def mortar_pressure(traces: Any, compliance: Any, integrals: Floats) -> Floats:
    """Return the pressure lambda_h (N/m^2) at all points, on every rank, from M and B x."""
    multiplier = spsolve(everywhere(compliance).tocsc(), integrals)
    at_points = local_part(traces) @ multiplier
    return np.concatenate(traces.comm.tompi4py().allgather(at_points))


class Eliminated:
    """Dense B, B_k and factors of M on the unknowns they touch, the same on every rank.

    A nonlinear law uses the closure projected on the traces of side a. With N the traces psi at the
    points and M_ij = int psi_i psi_j,

        g = N M^-1 (B x - N^T w g_n),    r = (B - mu B_k)^T M^-1 N^T w sigma(g),

    the multiplier is the projected pressure. For uniform p this is the mortar contact of a linear
    law.
    """

    def __init__(self, traces: Any, weight: Floats, M: Any, gap: Any, slip: Any | None) -> None:
        self._traces, self._weight, self._gap = traces, weight, gap
        dense = everywhere(M).toarray()
        scale = 1 / np.sqrt(np.diag(dense))
        scaled = scale[:, None] * dense * scale
        factor, order, rank, _ = lapack.dpstrf(scaled, tol=_INDEPENDENT)
        self._kept = order[:rank] - 1  # linearly independent traces
        self._scale, self._factor = scale[self._kept, None], np.triu(factor[:rank, :rank])
        wholes = [everywhere(each)[self._kept] for each in (gap, slip) if each is not None]
        self._columns = np.unique(np.concatenate([w.indices[w.data != 0] for w in wholes]))
        self._integrals = [whole[:, self._columns].toarray() for whole in wholes]

    @cached_property
    def _at_points(self) -> csr_array:
        """N, traces at all points, shape (n, m)."""
        return csr_array(everywhere(self._traces)[:, self._kept])

    def closing(self, x: Floats) -> Floats:
        """Return N M^-1 B x for unknowns x, the rows of this rank, shape (n,)."""
        every = np.concatenate(self._gap.comm.tompi4py().allgather(x))
        multipliers = self._solve(self._integrals[0] @ every[self._columns, None])
        return (self._at_points @ multipliers)[:, 0]

    def projected(self, gap: Floats) -> Floats:
        """Return a gap projected on the traces, shape (n,)."""
        return (self._at_points @ self._multipliers(gap))[:, 0]

    def pushed(self, pressure: Floats, *, friction: bool) -> Floats:
        """Return the forces r of a pressure at all points, the rows of this rank."""
        multipliers = self._multipliers(pressure)[:, 0]
        values = self._integrals[0].T @ multipliers
        if friction:
            values -= self._integrals[1].T @ multipliers
        force, (mine, start) = np.zeros(self._gap.getLocalSize()[1]), self._mine()
        force[self._columns[mine] - start] = values[mine]
        return force

    def tangent(self, slope: Floats) -> tuple[Any, Any | None]:
        """Return K_n and K_f, the derivative of r, for a slope of the law; dense matrices."""
        weighted = diags_array(self._weight * slope) @ self._at_points
        return self.matrices(csr_array(self._at_points.T @ weighted))

    def matrices(self, inner: csr_array | None = None) -> tuple[Any, Any | None]:
        """Return K_n and K_f with M^-1, or with M^-1 A M^-1 for a given inner A, PETSc AIJ."""
        multipliers = self._solve(self._integrals[0])
        if inner is not None:
            multipliers = self._solve(inner @ multipliers)
        normal, *friction = (each.T @ multipliers for each in self._integrals)
        K_n = self._matrix(0.5 * (normal + normal.T))
        K_n.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return K_n, self._matrix(friction[0]) if friction else None

    def _solve(self, right: Floats) -> Floats:
        """Return M^-1 times a block."""
        return self._scale * cho_solve((self._factor, False), self._scale * right)

    def _multipliers(self, values: Floats) -> Floats:
        """Return M^-1 N^T w times values at all points, shape (m, 1)."""
        return self._solve(self._at_points.T @ (self._weight * values)[:, None])

    def _matrix(self, block: Floats) -> Any:
        mine, start = self._mine()
        local, total = self._gap.getSizes()[1]
        lengths = np.zeros(local, dtype=np.int64)
        lengths[self._columns[mine] - start] = len(self._columns)
        indptr = np.concatenate([[0], np.cumsum(lengths)])
        indices = np.tile(self._columns, len(mine))
        rows = csr_array((block[mine].ravel(), indices, indptr), shape=(local, total))
        return distributed(rows, self._gap.getSizes()[1], self._gap.comm)

    def _mine(self) -> tuple[Ints, int]:
        """Return which columns are unknowns of this rank, and its first unknown."""
        first, last = self._gap.getOwnershipRangeColumn()
        return np.flatnonzero((self._columns >= first) & (self._columns < last)), first


def everywhere(matrix: Any) -> csr_array:
    """Return all rows of a matrix on every rank."""
    return csr_array(vstack(matrix.comm.tompi4py().allgather(local_part(matrix))))


def _at(interface: Interface, traces: csr_array, points: NDArray[np.bool_]) -> csr_array:
    """Return the traces of this rank, set to zero at all but the given points."""
    seen = traces.copy()
    seen.data = seen.data * np.repeat(points[interface.rows], np.diff(seen.indptr))
    seen.eliminate_zeros()
    return seen


def _seen_by_any(seen: csr_array, comm: Any) -> Ints:
    """Return the sorted traces that are nonzero at a point of any rank."""
    return np.unique(np.concatenate(comm.allgather(np.unique(seen.indices))))


def _independent(gram: csr_array, cut: NDArray[np.bool_], comm: Any) -> Ints:
    """Return linearly independent traces at the closed points, the same on every rank.

    Traces cut by an open region may outnumber the closed points in their support; the pivoted
    Cholesky factorisation of their Schur complement finds the independent ones.
    """
    kept: Ints | None = None
    if comm.rank == 0:
        scale = diags_array(1 / np.sqrt(gram.diagonal()))
        scaled = csr_array(scale @ gram @ scale)
        added = scaled[cut][:, cut].toarray()
        if not cut.all():
            beside = scaled[~cut][:, cut].toarray()
            added -= beside.T @ splu(scaled[~cut][:, ~cut].tocsc()).solve(beside)
        _, order, rank, _ = lapack.dpstrf(added, tol=_INDEPENDENT_CUT)
        needed = np.flatnonzero(cut)[order[:rank] - 1]
        kept = np.sort(np.concatenate([np.flatnonzero(~cut), needed]))
    return np.asarray(comm.bcast(kept))
