"""Forces of what loads the surfaces of a body of patches."""

from collections.abc import Mapping, Sequence

import numpy as np

from cea.arrays import Floats
from cea.supports.boundary import Force, Pressure, on_surfaces
from iga_cea.surface import NurbsSurface


def surface_forces(
    surfaces: Mapping[str, NurbsSurface],
    pressures: Sequence[Pressure],
    forces: Sequence[Force],
    shape: tuple[int, int],
    points: int,
) -> Floats:
    """Forces on all scalar dofs (N).

    Parameters
    ----------
    surfaces
        All surfaces of the body by name.
    pressures, forces
        Its loads; forces on every part of it are left out.
    shape
        Scalar dofs of the body, and dimension of space.
    points
        Gauss points of a span along each parameter.
    """
    total = np.zeros(shape)
    for pressure in pressures:
        surface = surfaces[pressure.surface]
        at = surface.gauss_points(points)
        traction = -pressure.value * at.normal
        total += surface.trace(at.at).T @ (at.weight[:, None] * traction)
    for name, value in on_surfaces(forces):
        at = surfaces[name].gauss_points(points)
        share = surfaces[name].trace(at.at).T @ at.weight
        total += share[:, None] * value / at.weight.sum()
    return total
