"""What rounding makes of the eigenvalues of a reduced model.

Full solves have errors of their own. Besides, entries of the reduced matrices sum_j c_j V^T A_j V are
known to a few units in the last place of their parts, which moves an eigenvalue of condition c by

    c 2 eps |y|^T (sum_j |c_j| |V^T A_j V|) |x|

at most (componentwise backward error; N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed.,
SIAM (2002), section 7.2). Where a contact is stiff, x all but closes its gap and P x^T V^T A V x is
of the size of its forces; what rounding leaves of V^T A V is not, and grows with P.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.pencil import Role
from cea.eigen.sensitivity import POWERS

_ENTRY = 2 * np.finfo(float).eps
"""Error of an entry relative to its parts: it is summed, stored, and summed with others again."""


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
        return self.solves + _ENTRY * works

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
        return float(_ENTRY * np.linalg.norm(block, 2))

    def _sizes(self, vectors: Complexes) -> Floats:
        return np.abs(vectors if self.axes is None else self.axes @ vectors)
