"""A disc without a hole, whose patches are collapsed at the axis, and a ring under pressure."""

import numpy as np
import pytest
from bodies import nurbs_body
from iga_data import STEEL, TILTED, body
from petsc_matrices import to_scipy
from scipy.sparse.linalg import eigsh, spsolve

from cea.material import IsotropicMaterial
from cea.supports.boundary import Pressure, Spring, Support
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.placement import Placement
from meshes.shapes import Disc, Ring

RADIUS, BOTTOM, TOP = 1.2, -0.1, 0.2
DISC = Disc(RADIUS, BOTTOM, TOP)


def test_one_dof_a_level_at_the_axis() -> None:
    part = body(DISC, (3, 8, 2), (2, 3, 2), Placement())
    radial, around, levels = 3 + 2, 4 * (2 + 2), 2 + 2
    assert part.num_scalar_dofs == ((radial - 1) * around + 1) * levels
    at_axis = np.linalg.norm(part.space.dof_positions[:, :2], axis=1) < 1e-12
    assert at_axis.sum() == levels
    assert len(np.unique(np.round(part.space.dof_positions, 9), axis=0)) == part.num_scalar_dofs


@pytest.mark.parametrize(
    "radius", [0.0, *(pytest.param(r, marks=pytest.mark.slow) for r in (1e-9, 1e-4, 0.1))]
)
def test_location_about_the_axis(radius: float) -> None:
    rng = np.random.default_rng(3)
    r, angle = radius * rng.random(1000), rng.uniform(0, 2 * np.pi, 1000)
    x = np.stack([r * np.cos(angle), r * np.sin(angle), np.full(1000, TOP + 0.05)], axis=1)
    top = body(DISC, (3, 8, 2), (2, 3, 2)).surfaces["top"]
    up = np.broadcast_to(TILTED.rotation[:, 2], x.shape)
    found = top.locate(TILTED.apply(x), up, 0.1)
    assert not found.missed.any()
    assert np.abs(found.distance + 0.05).max() < 1e-14
    foot = TILTED.apply(x - [0, 0, 0.05])
    assert np.abs(top.position(found.at) - foot).max() < 1e-8


@pytest.mark.slow
def test_clamped_thin_disc_against_plate_theory() -> None:
    """Frequencies a^2 sqrt(rho h / D) omega of a clamped plate (Leissa, Vibration of Plates).

    Shear and rotary inertia, which plate theory leaves out, lower them by some (h / a)^2. Elements
    at the rim resolve the layer, as thick as the plate, where the clamp holds back Poisson strain.
    """
    h, material = 0.01, IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
    shape = Disc(1.0, -h / 2, h / 2)
    data = nurbs_shape(shape, breaks_of(shape, (12, 16, 1), {"r": [0.95, 0.97, 0.985, 0.995]}))
    held = [Support("outer", (0, 1, 2))]
    part = nurbs_body(
        "disc",
        data.patches,
        {"outer": data.faces["outer"]},
        (4, 4, 3),
        material=material,
        supports=held,
    )
    K, M = to_scipy(part.stiffness()).tocsc(), to_scipy(part.mass()).tocsc()
    kappa = np.sort(eigsh(K, 6, M, sigma=0, return_eigenvectors=False))
    rigidity = 2.0 * h**3 / (12 * (1 - 0.3**2))
    numbers = np.sqrt(kappa * 1.5 * h / rigidity)
    leissa = [10.2158, 21.26, 21.26, 34.88, 34.88, 39.771]
    np.testing.assert_allclose(numbers, leissa, rtol=1e-3)
    assert numbers[2] - numbers[1] < 1e-6 * numbers[1]


def test_ring_under_pressure_against_lame() -> None:
    """Radial displacement of a thick ring in plane strain; a soft foundation holds its place."""
    inner, outer = 0.8, 1.7
    part = body(
        Ring(inner, outer),
        (6, 24),
        (4, 4),
        Placement(),
        springs=[Spring("outer", (1e-9, 1e-9))],
        pressures=[Pressure("inner", 0.7)],
    )
    points = part.surfaces["inner"].gauss_points(3)
    x = spsolve(to_scipy(part.stiffness()).tocsc(), part.load().getArray())
    moved = part.surfaces["inner"].trace(points.at) @ (to_scipy(part.expansion) @ x).reshape(-1, 2)
    E, nu, ratio = STEEL.E, STEEL.nu, (outer / inner) ** 2
    radial = 0.7 * inner * (1 + nu) / E * ((1 - 2 * nu) + ratio) / (ratio - 1)
    drift = moved.mean(axis=0)  # what rounding leaves of the resultant moves the foundation
    assert np.abs(drift).max() < 1e-5 * radial
    np.testing.assert_allclose(moved - drift, -radial * points.normal, atol=1e-6 * radial)
