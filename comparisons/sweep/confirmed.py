"""Thresholds of a map beside full solves."""

from collections.abc import Mapping

import numpy as np

from cea.eigen.krylov_schur import KrylovSchur
from cea.reduced.onsets import Onset

_ASIDE = 1e-3
"""Relative distance from the pair at which it is looked for: a pencil is singular on it."""
_NEIGHBOURS = 4


def confirmed(driver: KrylovSchur, point: Mapping[str, float], found: Onset) -> float:
    """How far the threshold of the pencil itself is from that of a reduced model.

    The discriminant of the pair by a full solve at the threshold found, over its slope.

    Parameters
    ----------
    driver
        What solves the pencil.
    point
        Parameters at the threshold.
    found
        The threshold.
    """
    mean = float(-(found.eigenvalue**2).real)
    modes = driver.nearest((1 + _ASIDE) * mean, _NEIGHBOURS, point)
    kappa = -(modes.eigenvalues**2)
    pair = kappa[np.argsort(np.abs(kappa - mean))[:2]]
    return float(((pair[0] - pair[1]) ** 2).real / abs(found.slope))
