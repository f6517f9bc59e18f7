"""What rounding makes of the eigenvalues of a reduced model.

Full solves have errors of their own. Besides, entries of the reduced matrices sum_j c_j V^T A_j V
are rounded relative to their parts: as they are made, and in the solution of the eigenvalue problem
of k unknowns, whose sums of k terms add up sqrt(k) eps. That moves an eigenvalue of condition c by

    c sqrt(k) eps |y|^T (sum_j |c_j| |V^T A_j V|) |x|

(componentwise backward error; N. J. Higham, T. Mary, A new approach to probabilistic rounding error
analysis, SIAM J. Sci. Comput. 41 (2019)). Where a contact is stiff, x all but closes its gap: parts
of P x^T V^T A V x cancel to the work of its forces, and what rounding leaves of them grows with P.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.left_vectors import POWERS
from cea.eigen.pencil import Role


@dataclass(frozen=True)
class Rounding:
    """What rounding does at given parameters.

    Parameters
    ----------
    solves
        What that of full solves does to eigenvalues of condition one (1/s^2).
    entries
        sum_j |c_j| |V^T A_j V| by role, shape (k, k) each, on the basis that the pencil itself was
        projected on.
    axes
        Vectors of a local basis in that one; None where vectors are of that one.
    """

    solves: float
    entries: Mapping[Role, Floats]
    axes: Floats | None = None

    def of_pairs(self, left: Complexes, right: Complexes, speeds: Floats) -> Floats:
        """What it does to y^H (lambda^2 M + lambda D + K) x of pairs (1/s^2), shape (n,).

        Parameters
        ----------
        left, right
            Coordinates of y and x of M-norm one, shape (k, n).
        speeds
            abs(lambda) (1/s), shape (n,).
        """
        y, x = self._sizes(left), self._sizes(right)
        works = np.zeros(len(speeds))
        for role, entries in self.entries.items():
            works += speeds ** POWERS[role] * np.einsum("ij,ij->j", y, entries @ x)
        return self.solves + _of_sums(len(y)) * works

    def of_block(self, left: Complexes, right: Complexes, speed: float) -> float:
        """Norm of the perturbation of the block of a cluster by that of entries (1/s^2).

        Parameters
        ----------
        left, right
            Coordinates of its left and right vectors, shape (k, p).
        speed
            Norm of the block of eigenvalues lambda (1/s).
        """
        y, x = self._sizes(left), self._sizes(right)
        block = np.zeros((y.shape[1], x.shape[1]))
        for role, entries in self.entries.items():
            block += speed ** POWERS[role] * (y.T @ entries @ x)
        return float(_of_sums(len(y)) * np.linalg.norm(block, 2))

    def _sizes(self, vectors: Complexes) -> Floats:
        return np.abs(vectors if self.axes is None else self.axes @ vectors)


def _of_sums(terms: int) -> float:
    """Error of sums of so many terms, relative to these."""
    return float(np.sqrt(terms) * np.finfo(float).eps)
