"""Mortar contact: the gap projected on the trace space of side a.

With psi_i the traces of side a and g the gap, the multiplier lambda_h = sum_i l_i psi_i obeys
M l = B x, where

    B_i = int psi_i g,   M_ij = int psi_i psi_j / p,   (B_k)_i = int mu psi_i [[u]].k,

and K_n = B^T M^-1 B, K_f = B_k^T M^-1 B. With R R^T = M^-1 these are K_n = G^T G and K_f = T^T G
for G = R^T B and T = R^T B_k: the same algebra as that of a point rule, a row for each multiplier.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array, diags_array

from cea.body import Floats
from cea.contact.interface import Interface, along, local_rows
from cea.petsc import MPI

_NEGLIGIBLE = 1e-12
"""Multipliers whose share of the overlap is below this part of the largest are dropped."""


@dataclass(frozen=True)
class MortarProjection:
    """Projection of functions at segment points on the trace space of side a.

    Parameters
    ----------
    interface
        Segment points and traces.
    traces
        psi at the points of this rank, shape (n_local, m).
    root
        R, shape (m, multipliers).
    """

    interface: Interface
    traces: csr_array
    root: Floats

    @classmethod
    def of(cls, interface: Interface, stiffness: Floats) -> "MortarProjection":
        """Set up the projection.

        Parameters
        ----------
        interface
            Segment points and traces.
        stiffness
            Contact stiffness p at all points (N/m^3), shape (n,).
        """
        comm = interface.comm
        touched = np.unique(np.concatenate(comm.allgather(interface.trace_a.indices)))
        traces = csr_array(interface.trace_a[:, touched])
        share = interface.local_points.weight / stiffness[interface.rows]
        mass = comm.allreduce((traces.T @ diags_array(share) @ traces).toarray(), MPI.SUM)
        values, vectors = eigh(0.5 * (mass + mass.T))
        kept = values > _NEGLIGIBLE * values[-1]
        return cls(interface, traces, vectors[:, kept] / np.sqrt(values[kept]))

    @property
    def weight(self) -> Floats:
        """Diagonal of D for the rows of this rank: ones."""
        start, stop = local_rows(self.root.shape[1], self.interface.comm)
        return np.ones(stop - start)

    def jump(self, direction: Floats, factor: Floats) -> tuple[csr_array, csr_array]:
        """Parts on a and b of the projected jump along a direction, the rows of this rank.

        Parameters
        ----------
        direction
            Unit vectors at the points of this rank, (n_local, dim).
        factor
            Factor at the points of this rank, e.g. the friction coefficient, (n_local,).

        Returns
        -------
        tuple
            Operators on full dofs, shape (rows, dim * num_scalar_dofs) each.
        """
        weighted = self.traces.T @ diags_array(self.interface.local_points.weight * factor)
        return (
            self._project(weighted @ along(self.interface.trace_a, direction)),
            self._project(-(weighted @ along(self.interface.trace_b, direction))),
        )

    def pressure(self, force: Floats) -> Floats:
        """Contact pressure lambda_h (N/m^2) at all points from G x."""
        return np.concatenate(self.interface.comm.allgather(self.traces @ (self.root @ force)))

    def _project(self, integrals: csr_array) -> csr_array:
        whole = csr_array(self.interface.comm.allreduce(csr_array(integrals), MPI.SUM))
        columns = np.unique(whole.indices[whole.data != 0])
        rows = self.root[:, slice(*local_rows(self.root.shape[1], self.interface.comm))].T
        block = rows @ whole[:, columns].toarray()
        indptr = np.arange(len(block) + 1, dtype=np.int64) * len(columns)
        return csr_array(
            (block.ravel(), np.tile(columns, len(block)), indptr),
            shape=(len(block), whole.shape[1]),
        )
