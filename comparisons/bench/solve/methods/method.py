"""What a method gives."""

from dataclasses import dataclass, field

import numpy as np

from cea.arrays import Complexes


@dataclass(frozen=True)
class Answer:
    """Eigenvalues of K x = kappa M x.

    Parameters
    ----------
    kappa
        Eigenvalues (1/s^2), those of conjugate pairs both, shape (n,).
    vectors
        Their vectors, the rows of this rank, shape (n_local, n).
    claims
        What the method says of itself, in words.
    stages
        Processor seconds of its stages on this rank, where it tells.
    """

    kappa: Complexes
    vectors: Complexes
    claims: str = ""
    stages: dict[str, float] = field(default_factory=dict)

    def inside(self, top: float) -> "Answer":
        """Those up to the end of a window."""
        kept = np.abs(np.sqrt(-self.kappa.astype(complex)).imag) <= np.sqrt(top)
        return Answer(self.kappa[kept], self.vectors[:, kept], self.claims, self.stages)
