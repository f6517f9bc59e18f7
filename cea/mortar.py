"""Mortar contact: the gap projected on the trace space of side a.

With psi_i the traces of side a and g the gap, the multiplier lambda_h = sum_i l_i psi_i obeys
M l = B x, where

    B_i = int psi_i g,   M_ij = int psi_i psi_j / p,   (B_k)_i = int mu psi_i [[u]].k,

and K_n = B^T M^-1 B, K_f = B_k^T M^-1 B. With M = L L^T these are K_n = G^T G and K_f = T^T G for
the whitened operators G = L^-1 B and T = L^-1 B_k: the same algebra as that of a point rule.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array, dia_array, diags_array

from cea.body import Floats, SurfacePoints
from cea.errors import InputError
from cea.interface import along

_NEGLIGIBLE = 1e-12
"""Multipliers whose share of the overlap is below this part of the largest are dropped."""


@dataclass(frozen=True)
class MortarProjection:
    """Projection of functions at segment points on the trace space of side a, whitened.

    Parameters
    ----------
    points
        Segment points on side a.
    weights
        Matrix (multipliers x points) that makes L^-1 int psi_i f from values of f at the points.
    """

    points: SurfacePoints
    weights: Floats

    @classmethod
    def of(cls, points: SurfacePoints, trace_a: csr_array, stiffness: Floats) -> "MortarProjection":
        """Set up the projection.

        Parameters
        ----------
        points
            Segment points on side a.
        trace_a
            Trace of side a there, shape (n, num_scalar_dofs).
        stiffness
            Contact stiffness p at the points (N/m^3), shape (n,).
        """
        if not len(points):
            raise InputError("mortar", 0, "surfaces that overlap: no segment joins them")
        psi = trace_a[:, np.unique(trace_a.indices)]
        weighted = psi.T @ diags_array(points.weight)
        mass = (weighted @ diags_array(1 / stiffness) @ psi).toarray()
        values, vectors = eigh(0.5 * (mass + mass.T))
        kept = values > _NEGLIGIBLE * values[-1]
        root = vectors[:, kept] / np.sqrt(values[kept])
        return cls(points, root.T @ weighted.toarray())

    def jump(
        self,
        trace_a: csr_array,
        trace_b: csr_array,
        direction: Floats,
        factor: Floats | None = None,
    ) -> tuple[csr_array, csr_array]:
        """Parts on a and b of the projected jump along a direction.

        Parameters
        ----------
        trace_a, trace_b
            Traces at the points, (n, num_scalar_dofs) each.
        direction
            Unit vectors at the points, (n, dim).
        factor
            Factor at the points, e.g. the friction coefficient, (n,).

        Returns
        -------
        tuple
            Operators (multipliers, dim * num_scalar_dofs) on full dofs.
        """
        scale = np.ones(len(self.points)) if factor is None else factor
        return tuple(
            self._project(sign * diags_array(scale) @ along(trace, direction))
            for sign, trace in ((1.0, trace_a), (-1.0, trace_b))
        )

    def _project(self, operator: csr_array | dia_array) -> csr_array:
        operator = csr_array(operator)
        columns = np.unique(operator.indices[operator.data != 0])
        block = self.weights @ operator[:, columns].toarray()
        rows = len(block)
        indptr = np.arange(rows + 1, dtype=np.int64) * len(columns)
        return csr_array(
            (block.ravel(), np.tile(columns, rows), indptr), shape=(rows, operator.shape[1])
        )
