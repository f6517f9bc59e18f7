"""Boundary stress of a body on its surfaces."""

import numpy as np

from cea.arrays import Floats
from cea.material import IsotropicMaterial
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates


def boundary_stress(
    surface: Surface, at: SurfaceCoordinates, displacement: Floats, material: IsotropicMaterial
) -> Floats:
    """Cauchy stress of a body at points of its surface.

    Parameters
    ----------
    surface
        Surface of the body.
    at
        Points of the surface.
    displacement
        Full displacement (m), shape (dim * num_scalar_dofs,).
    material
        Material of the body.

    Returns
    -------
    ndarray
        Stress (N/m^2), shape (n, dim, dim).
    """
    u = displacement.reshape(-1, surface.dim)
    gradient = np.stack([derivative @ u for derivative in surface.gradient(at)], axis=2)
    return material.stress(gradient)


def normal_stress(
    surface: Surface, at: SurfaceCoordinates, displacement: Floats, material: IsotropicMaterial
) -> Floats:
    """Stress n.sigma.n (N/m^2) with n the outward normal, shape (n,); tension is positive."""
    normal = surface.normal(at)
    stress = boundary_stress(surface, at, displacement, material)
    return np.einsum("ni,nij,nj->n", normal, stress, normal)
