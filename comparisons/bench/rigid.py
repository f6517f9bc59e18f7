"""Rigid motions in space, by their values at points or as functions."""

from collections.abc import Callable
from typing import Literal

import numpy as np

from cea.arrays import Floats


def rigid_motions(
    points: Floats, layout: Literal["interleaved", "blocked"] = "interleaved"
) -> Floats:
    """The rigid motions by their values at points.

    Parameters
    ----------
    points
        The points, shape (n, 3).
    layout
        Whether the three components of a point follow each other, or all points of a component.

    Returns
    -------
    ndarray
        Three translations, then three rotations about the axes, shape (3 n, 6).
    """
    motions = np.zeros((len(points), 3, 6))
    motions[:, [0, 1, 2], [0, 1, 2]] = 1.0
    x, y, z = points.T
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 2, 4], motions[:, 0, 4] = -x, z
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    if layout == "blocked":
        motions = motions.transpose(1, 0, 2)
    return motions.reshape(-1, 6)


def motion_fields() -> list[Callable[[Floats], Floats]]:
    """The rigid motions as functions of points, shape (3, ...), of the same shape."""

    def translation(component: int) -> Callable[[Floats], Floats]:
        return lambda x: np.stack([np.full(x[0].shape, float(i == component)) for i in range(3)])

    def rotation(axis: int) -> Callable[[Floats], Floats]:
        spin = np.eye(3)[axis]
        return lambda x: np.cross(spin, x, axisb=0, axisc=0)

    return [*map(translation, range(3)), *map(rotation, range(3))]
