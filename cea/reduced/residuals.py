"""A reduced matrix with what residuals need."""

from dataclasses import dataclass

from cea.arrays import Complexes, Floats
from cea.reduced.stiff_norm import StiffNorm


@dataclass(frozen=True)
class Residuals:
    """K or M of a reduced model at given parameters, with what its residuals need.

    Parameters
    ----------
    square
        V^T A V, shape (k, k).
    right, left
        Q^T A V and Q^T A^T V, shape (q, k).
    lost
        Norm of what these leave out.
    norm
        Measures residuals where a stiffness is larger; None leaves their lengths.
    """

    square: Floats
    right: Floats
    left: Floats
    lost: float
    norm: StiffNorm | None = None

    def measured(self, residuals: Complexes) -> Complexes:
        """Coordinates of residuals, shape (q, n), whose lengths are their norms."""
        return residuals if self.norm is None else self.norm(residuals)
