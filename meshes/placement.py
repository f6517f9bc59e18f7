"""Placement of a shape in space."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from cea.arrays import Floats, of_size_one
from cea.errors import require


@dataclass(frozen=True)
class Placement:
    """Rotation about an axis through the origin, then a translation.

    Parameters
    ----------
    axis
        Rotation axis, any length but zero.
    angle
        Rotation angle (degrees).
    translation
        Translation (m).
    """

    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    angle: float = 0.0
    translation: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        require(bool(np.any(self.axis)), "axis", self.axis, "a vector that is not zero")

    @property
    def rotation(self) -> Floats:
        """Rotation matrix, (3, 3)."""
        axis = of_size_one(self.axis)
        vector = axis / np.linalg.norm(axis) * self.angle
        return Rotation.from_rotvec(vector, degrees=True).as_matrix()

    def check(self, dim: int, field: str) -> None:
        """Refuse a placement that moves a plane body out of its plane."""
        if dim == 2:
            stays = np.allclose(self.rotation[2], [0, 0, 1]) and self.translation[2] == 0
            require(bool(stays), field, self, "a rotation about z and a shift in x, y")

    def apply(self, points: Floats) -> Floats:
        """Placed copies of points (m), shape (..., 3), or (..., 2) in plane strain."""
        dim = points.shape[-1]
        self.check(dim, "placement")
        rotation, translation = self.rotation, np.asarray(self.translation)
        return points @ rotation[:dim, :dim].T + translation[:dim]


IN_PLACE = Placement()
"""No rotation and no translation."""
