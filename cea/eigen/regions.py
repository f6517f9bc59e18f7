"""Region of kappa that belongs to a window, and the discs that cover it.

Modes with 0 <= Im lambda <= omega, of any growth, have kappa = -lambda^2 inside the parabola

    |kappa| + Re kappa <= 2 omega^2,   (Im kappa)^2 <= 4 omega^2 (omega^2 - Re kappa).

A disc that contains the part of the parabola with -X <= Re kappa <= -Y, and has both of its ends
on the edge, has the

    centre -(X + Y) / 2 - 2 omega^2.

With Y = -omega^2 it touches the tip, and contains no more of the positive axis than the window.
Friction may move eigenvalues to the left in the parabola. The field of values bounds how far, and
often confines them to a cone about the real axis (:mod:`cea.eigen.field_of_values`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats

_MARGIN = 1.05
"""Radius of the disc about the middle of the window relative to half the window."""
TIP = 1.01
"""Tip of the covered parabola relative to omega^2. The margin separates the edge of the disc from
the end of the window."""


@dataclass(frozen=True)
class Disc:
    """A disc about a real shift: of kappa (1/s^2), or with damping or rotation of lambda (1/s)."""

    centre: float
    radius: float


def upper_end(top: float) -> float:
    """Return the upper end of the disc about the middle of a window that ends at ``top`` = omega^2.

    Both are in 1/s^2.
    """
    return 0.5 * top * (1 + _MARGIN)


def covering_disc(top: float, left: float, right: float) -> Disc:
    """Return the disc that covers the parabola with left <= Re kappa <= right (1/s^2)."""
    centre = 0.5 * (left + right) - 2 * TIP * top
    return Disc(centre, distance_within(top, centre, left, right))


def outside_of_window(upper: float, kappa: Complexes, errors: Floats) -> NDArray[np.bool_]:
    """Return which kappa lie outside the parabola by more than their errors (1/s^2), shape (n,)."""
    return np.abs(kappa) + kappa.real - 2 * errors > 2 * upper


def distance_within(top: float, centre: float, left: float, right: float) -> float:
    """Return the largest distance from a centre to the parabola with left <= Re kappa <= right.

    The distance is convex along the parabola, so it is largest at an end.
    """
    tip = TIP * top
    ends = np.array([left, right])
    heights = 4 * tip * np.maximum(tip - ends, 0.0)
    return float(np.sqrt((ends - centre) ** 2 + heights).max())


def distance_of_cone(top: float, centre: float, depth: float, slope: float) -> float:
    """Return the largest distance to the parabola with abs(Im kappa) <= slope (Re kappa + depth).

    It is attained at the tip of the cone, where cone and parabola meet, or at the parabola's tip.
    """
    if np.isinf(slope):
        return np.inf
    tip, square = TIP * top, slope**2
    linear, constant = 2 * square * depth + 4 * tip, 4 * tip**2 - square * depth**2
    meet = 2 * constant / (linear + np.sqrt(linear**2 + 4 * square * constant))
    height = 2 * np.sqrt(tip * max(tip - meet, 0.0))
    return float(max(abs(-depth - centre), np.hypot(meet - centre, height), abs(tip - centre)))
