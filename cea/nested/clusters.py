"""Eigenvalues judged together: near a coalescence the mean is sound, the members are not.

Of a pair a, b that nearly meets, ((a - b) / 2)^2 is the discriminant d, which varies smoothly with
the problem while the members vary like its root. Without damping a, b are kappa = -lambda^2, real
numbers where d > 0, and the pair flutters where d < 0.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Complexes, Ints
from cea.eigen.matching import connected

NEAR = 2.0
"""Distance, in errors of both, within which eigenvalues are judged together."""


@dataclass(frozen=True)
class Cluster:
    """Eigenvalues that are judged together; most stand alone.

    Means and splittings are those of kappa = -lambda^2 (1/s^2) without damping, with damping or
    rotation those of lambda (1/s), on the coarse mesh and in the richer space.
    """

    members: Ints  # modes, (n,)
    mean: complex
    corrected_mean: complex
    splitting: complex  # of pairs, ((a - b) / 2)^2; not a number for other sizes
    corrected_splitting: complex

    @property
    def mean_error(self) -> float:
        """Estimated error of the mean on the coarse mesh."""
        return abs(self.corrected_mean - self.mean)

    @property
    def splitting_error(self) -> float:
        """Estimated error of the splitting on the coarse mesh; not a number but for pairs."""
        return abs(self.corrected_splitting - self.splitting)

    @property
    def meets(self) -> bool:
        """Whether it is a pair of real kappa, or of conjugate ones: the two kinds of a pair."""
        return bool(abs(self.corrected_splitting.imag) <= self.splitting_error)

    @property
    def decided(self) -> bool:
        """Whether the sign of the splitting is beyond its error."""
        return bool(abs(self.corrected_splitting.real) > self.splitting_error)

    @property
    def flutters(self) -> bool:
        """Whether the corrected splitting is that of conjugate kappa."""
        return self.corrected_splitting.real < 0


def clusters_of(coarse: Complexes, corrected: Complexes) -> tuple[Cluster, ...]:
    """Sets of eigenvalues nearer to each other than their errors allow to tell apart.

    The eigenvalues, kappa without damping, lambda with, are in the same order, shape (n,).
    """
    errors = np.abs(corrected - coarse)
    reach = NEAR * (errors[:, None] + errors)
    linked = np.zeros(reach.shape, dtype=bool)
    for values in (coarse, corrected):
        linked |= np.abs(values[:, None] - values) <= reach
    return tuple(
        Cluster(
            members,
            complex(coarse[members].mean()),
            complex(corrected[members].mean()),
            complex(splitting(coarse[members])),
            complex(splitting(corrected[members])),
        )
        for members in connected(linked)
    )


def splitting(values: Complexes) -> Any:
    """((a - b) / 2)^2 of pairs along the last axis; not a number for other sizes."""
    if values.shape[-1] != 2:
        return np.nan * values[..., 0]
    return ((values[..., 0] - values[..., 1]) / 2) ** 2
