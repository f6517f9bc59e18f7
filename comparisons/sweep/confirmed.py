"""Thresholds of a map beside full solves."""

from collections.abc import Mapping

import numpy as np

from cea.eigen.krylov_schur import KrylovSchur
from cea.reduced.crossings import Threshold

_ASIDE = 1e-3
"""Relative distance from the pair at which it is looked for: a pencil is singular on it."""
_NEIGHBOURS = 4


def confirmed(
    driver: KrylovSchur,
    point: Mapping[str, float],
    found: Threshold,
    level: float,
    max_frequency: float,
) -> float | None:
    """How far the threshold of the pencil itself is from that of a reduced model.

    What passes zero there, from a full solve at the threshold found, over its slope; None where
    only the numbers of growing modes on both sides are known.

    Parameters
    ----------
    driver
        What solves the pencil.
    point
        Parameters at the threshold.
    found
        The threshold.
    level
        Growth rate (1/s) from which on a mode counts as growing.
    max_frequency
        Upper end of the window (Hz).
    """
    if not found.slope:
        return None
    lam = found.eigenvalue if found.eigenvalue else 2j * np.pi * max_frequency * _ASIDE
    lam *= 1 + _ASIDE
    modes = driver.nearest(
        float(-(lam**2).real) if not driver.pencil.damped else -(lam**2), _NEIGHBOURS, point
    )
    nearest = modes.eigenvalues[np.argmin(np.abs(modes.eigenvalues - found.eigenvalue))]
    if found.kind == "window":
        return float((2 * np.pi * max_frequency - nearest.imag) / found.slope)
    if driver.pencil.damped or level:
        return float((level - nearest.real) / found.slope)
    near = -(modes.eigenvalues**2)
    if found.kind == "divergence":
        return float(-near[np.argmin(np.abs(near))].real / found.slope)
    mean = float(-(found.eigenvalue**2).real)
    pair = near[np.argsort(np.abs(near - mean))[:2]]
    return float(-(((pair[0] - pair[1]) / 2) ** 2).real / found.slope)
