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

    The discriminant of the pair by a full solve at the threshold found, or with damping or rotation
    the growth rate of the mode, over its slope.

    Parameters
    ----------
    driver
        What solves the pencil.
    point
        Parameters at the threshold.
    found
        The threshold.
    """
    if driver.pencil.damped:
        lam = found.eigenvalue * (1 + _ASIDE)
        modes = driver.nearest(-(lam**2), _NEIGHBOURS, point)
        own = modes.eigenvalues[np.argmin(np.abs(modes.eigenvalues - found.eigenvalue))]
        return float(-own.real / found.slope)
    mean = float(-(found.eigenvalue**2).real)
    modes = driver.nearest((1 + _ASIDE) * mean, _NEIGHBOURS, point)
    kappa = -(modes.eigenvalues**2)
    pair = kappa[np.argsort(np.abs(kappa - mean))[:2]]
    return float(((pair[0] - pair[1]) ** 2).real / abs(found.slope))
