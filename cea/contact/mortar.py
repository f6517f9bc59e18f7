"""Mortar contact: the gap projected on the trace space of side a.

With psi_i the traces of side a, split at corners where its normal jumps (:mod:`cea.corners`), and g
the gap, the multiplier lambda_h = sum_i l_i psi_i obeys M l = B x, where

    B_i = int psi_i g,   M_ij = int psi_i psi_j / p,   (B_k)_i = int mu psi_i [[u]].k,

and K_n = B^T M^-1 B, K_f = B_k^T M^-1 B. B and M are sparse, K_n and K_f full on the whole
interface: what is solved keeps l as unknowns (:mod:`cea.contact.saddle`). Bonded sides close the
jump along fixed axes, which is continuous over a corner: their traces stay whole. Where p is zero
the sides have lifted off: the integrals go over the rest of the interface, and traces that vanish
there bear no multiplier.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, solve_triangular
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.linalg import splu, spsolve

from cea.arrays import Floats, Ints
from cea.contact.interface import Interface
from cea.matrices import (
    block_diagonal,
    destroy,
    distributed,
    gather,
    local_part,
    product,
    symmetric_product,
)
from cea.ranks import local_rows

INDEPENDENT = 1e-15
"""Least pivot of M, scaled to a diagonal of ones, of a trace that is not a sum of others."""
INDEPENDENT_CUT = 1e-13
"""The same of traces that are cut by what is open: sparse factors do not find such dependences."""


@dataclass(frozen=True)
class MortarProjection:
    """Projection of functions at segment points on the trace space of side a.

    Parameters
    ----------
    interface
        Segment points.
    traces
        psi at the points, PETSc AIJ (points x m); zero at points that are left out.
    """

    interface: Interface
    traces: Any

    @classmethod
    def of(
        cls, interface: Interface, traces: csr_array, closed: NDArray[np.bool_] | None = None
    ) -> "MortarProjection":
        """The projection on all traces that some point sees.

        Parameters
        ----------
        interface
            Segment points.
        traces
            psi at the points of this rank, whole or split at corners.
        closed
            Which of all points count, shape (n,); None takes every one.
        """
        if closed is None or closed.all():
            seen = traces.copy()
            seen.eliminate_zeros()
            return cls(interface, _columns(seen, _seen_by_any(seen, interface.comm), interface))
        seen, beyond = (_at(interface, traces, points) for points in (closed, ~closed))
        touched = _seen_by_any(seen, interface.comm)
        every = cls(interface, _columns(seen, touched, interface))
        cut = np.isin(touched, _seen_by_any(beyond, interface.comm))
        gram = every.compliance(closed.astype(float))
        kept = _independent(everywhere(gram), cut, interface.comm)
        destroy(gram, every.traces)
        return cls(interface, _columns(seen, touched[kept], interface))

    def integrals(self, jump: Any) -> Any:
        """Int psi_i of a jump given at the points, PETSc AIJ (points x free dofs)."""
        weight = self._at_points(self.interface.local_points.weight)
        result = product(self.traces, jump, weight)
        destroy(weight)
        return result

    def compliance(self, stiffness: Floats) -> Any:
        """M, PETSc AIJ (m x m), symmetric to the last bit.

        Parameters
        ----------
        stiffness
            Contact stiffness p at all points (N/m^3), or a part of it, shape (n,); zero only at
            points that are left out.
        """
        own, area = stiffness[self.interface.rows], self.interface.local_points.weight
        share = np.divide(area, own, out=np.zeros(len(own)), where=own > 0)
        weight = self._at_points(share)
        result = symmetric_product(self.traces, weight)
        destroy(weight)
        return result

    def pressure(self, stiffness: Floats, closed: Any) -> Floats:
        """Contact pressure lambda_h (N/m^2) at all points, on every rank, from B x.

        Parameters
        ----------
        stiffness
            As for :meth:`compliance`.
        closed
            B x, PETSc vector (m).
        """
        compliance = self.compliance(stiffness)
        multiplier = spsolve(everywhere(compliance).tocsc(), gather(closed))
        destroy(compliance)
        at_points = local_part(self.traces) @ multiplier
        return np.concatenate(self.interface.comm.allgather(at_points))

    def _at_points(self, values: Floats) -> Any:
        vector = self.traces.createVecLeft()
        vector.array[:] = values
        return vector


def _at(interface: Interface, traces: csr_array, points: NDArray[np.bool_]) -> csr_array:
    """Traces of this rank at some of all points, none at the others."""
    seen = traces.copy()
    seen.data = seen.data * np.repeat(points[interface.rows], np.diff(seen.indptr))
    seen.eliminate_zeros()
    return seen


def _seen_by_any(seen: csr_array, comm: Any) -> Ints:
    """Traces that a point of some rank sees, rising."""
    return np.unique(np.concatenate(comm.allgather(np.unique(seen.indices))))


def _columns(seen: csr_array, touched: Ints, interface: Interface) -> Any:
    """Some traces as PETSc AIJ."""
    start, stop = local_rows(len(touched), interface.comm)
    columns = (stop - start, len(touched))
    return distributed(csr_array(seen[:, touched]), columns, interface.comm)


def _independent(gram: csr_array, cut: NDArray[np.bool_], comm: Any) -> Ints:
    """Traces of which none is a sum of others at the points that count, the same on every rank.

    Traces that are cut reach beyond those points, and there may be more of them than points that
    see them; what they add to the others, the Schur complement, tells which are needed.

    Parameters
    ----------
    gram
        Integrals of products of traces over the points that count, (m, m), on every rank.
    cut
        Which of the traces are cut, (m,).
    """
    kept: Ints | None = None
    if comm.rank == 0:
        scale = diags_array(1 / np.sqrt(gram.diagonal()))
        scaled = csr_array(scale @ gram @ scale)
        added = scaled[cut][:, cut].toarray()
        if not cut.all():
            beside = scaled[~cut][:, cut].toarray()
            added -= beside.T @ splu(scaled[~cut][:, ~cut].tocsc()).solve(beside)
        _, order, rank, _ = lapack.dpstrf(added, tol=INDEPENDENT_CUT)
        needed = np.flatnonzero(cut)[order[:rank] - 1]
        kept = np.sort(np.concatenate([np.flatnonzero(~cut), needed]))
    return np.asarray(comm.bcast(kept))


def repeated(matrix: Any, times: int) -> Any:
    """A matrix so many times along the diagonal, PETSc AIJ."""
    return block_diagonal([matrix] * times).convert("aij")


def eliminated(compliance: Any, gap: Any, slip: Any | None) -> tuple[Any, Any | None]:
    """K_n = B^T M^-1 B and K_f = B_k^T M^-1 B: full on the interface, for small ones.

    With R R^T = M^-1 they are G^T G and T^T G for G = R^T B and T = R^T B_k.

    Parameters
    ----------
    compliance
        M, PETSc AIJ (m x m).
    gap, slip
        B and B_k, PETSc AIJ (m x free dofs).

    Returns
    -------
    tuple
        PETSc AIJ; without B_k no K_f.
    """
    comm = gap.comm.tompi4py()
    M = everywhere(compliance).toarray()
    scale = 1 / np.sqrt(np.diag(M))
    factor, order, rank, _ = lapack.dpstrf(scale[:, None] * M * scale, tol=INDEPENDENT)
    kept = order[:rank] - 1
    start, stop = local_rows(rank, comm)
    reduced = []
    for operator in (gap, slip):
        if operator is None:
            continue
        whole = everywhere(operator)
        columns = np.unique(whole.indices[whole.data != 0])
        right = scale[kept, None] * whole[kept][:, columns].toarray()
        rows = solve_triangular(factor[:rank, :rank], right, trans="T", check_finite=False)
        block = _spread(rows[start:stop], columns, whole.shape[1])
        reduced.append(distributed(block, operator.getSizes()[1], operator.comm))
    one = reduced[0].createVecLeft()
    one.set(1.0)
    normal = symmetric_product(reduced[0], one)
    friction = product(reduced[1], reduced[0], one) if slip is not None else None
    destroy(one, *reduced)
    return normal, friction


def everywhere(matrix: Any) -> csr_array:
    """All rows of a matrix on every rank."""
    return csr_array(vstack(matrix.comm.tompi4py().allgather(local_part(matrix))))


def _spread(block: Floats, columns: Any, size: int) -> csr_array:
    """Dense columns in their places."""
    indptr = np.arange(len(block) + 1, dtype=np.int64) * len(columns)
    return csr_array((block.ravel(), np.tile(columns, len(block)), indptr), (len(block), size))
