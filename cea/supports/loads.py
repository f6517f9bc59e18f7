"""Springs, pressures and forces on surfaces, from the points and traces of these."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, kron

from cea.arrays import Floats
from cea.matrices import distributed
from cea.supports.boundary import Force, Pressure, Spring, on_surfaces
from cea.surface import Surface


def foundation(surface: Surface, spring: Spring, own: slice, comm: Any) -> Any:
    """Matrix of a spring: int k_c phi_m phi_n on the diagonal of components c."""
    points = surface.gauss_points(surface.cells().degree + 1)
    scaled = diags_array(np.sqrt(points.weight)) @ surface.trace(points.at)
    scalar = csr_array(scaled.T @ scaled)
    whole = csr_array(kron(scalar, diags_array(np.asarray(spring.stiffness)), format="csr"))
    rows = csr_array(whole[own])
    return distributed(rows, rows.shape, comm)


def surface_forces(
    surfaces: Mapping[str, Surface],
    pressures: Sequence[Pressure],
    forces: Sequence[Force],
    shape: tuple[int, int],
) -> Floats:
    """Forces of loads on surfaces on all scalar dofs (N); those on every part are left out."""
    total = np.zeros(shape)
    for pressure in pressures:
        surface = surfaces[pressure.surface]
        # Of facets of degree q, function times normal times area element has up to 3 q - 1.
        points = surface.gauss_points((3 * surface.cells().degree + 1) // 2)
        traction = -pressure.value * points.normal
        total += surface.trace(points.at).T @ (points.weight[:, None] * traction)
    for name, value in on_surfaces(forces):
        points = surfaces[name].gauss_points(surfaces[name].cells().degree + 1)
        share = surfaces[name].trace(points.at).T @ points.weight
        total += share[:, None] * value / points.weight.sum()
    return total
