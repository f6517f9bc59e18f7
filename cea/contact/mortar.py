"""Mortar contact: the gap projected on the trace space of side a.

With psi_i the traces of side a and g the gap, the multiplier lambda_h = sum_i l_i psi_i obeys
M l = B x, where

    B_i = int psi_i g,   M_ij = int psi_i psi_j / p,   (B_k)_i = int mu psi_i [[u]].k,

and K_n = B^T M^-1 B, K_f = B_k^T M^-1 B. B and M are sparse, K_n and K_f full on the whole
interface: what is solved keeps l as unknowns (:mod:`cea.contact.saddle`).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import lapack, solve_triangular
from scipy.sparse import csr_array, vstack
from scipy.sparse.linalg import spsolve

from cea.body import Floats
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


@dataclass(frozen=True)
class MortarProjection:
    """Projection of functions at segment points on the trace space of side a.

    Parameters
    ----------
    interface
        Segment points and traces.
    traces
        psi at the points, PETSc AIJ (points x m).
    """

    interface: Interface
    traces: Any

    @classmethod
    def of(cls, interface: Interface) -> "MortarProjection":
        """The projection on all traces that some point sees."""
        comm, seen = interface.comm, interface.trace_a.copy()
        seen.eliminate_zeros()
        touched = np.unique(np.concatenate(comm.allgather(np.unique(seen.indices))))
        start, stop = local_rows(len(touched), comm)
        columns = (stop - start, len(touched))
        return cls(interface, distributed(csr_array(seen[:, touched]), columns, comm))

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
            Contact stiffness p at all points (N/m^3), or a part of it, shape (n,).
        """
        share = self.interface.local_points.weight / stiffness[self.interface.rows]
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
