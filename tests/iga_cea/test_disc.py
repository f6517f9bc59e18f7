"""Disc without a hole: patches collapsed at the axis."""

import numpy as np
import pytest
from bodies import nurbs_body
from iga_data import STEEL, TILTED, body, scipy_of
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from cea.material import IsotropicMaterial
from cea.supports.boundary import Pressure, Support
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.placement import Placement
from meshes.shapes import Disc

RADIUS, BOTTOM, TOP = 1.2, -0.1, 0.2
DISC = Disc(RADIUS, BOTTOM, TOP)
AREA = np.pi * RADIUS**2


def test_one_dof_a_level_at_the_axis() -> None:
    part = body(DISC, (3, 8, 2), (2, 3, 2), Placement())
    radial, around, levels = 3 + 2, 4 * (2 + 2), 2 + 2
    assert part.num_scalar_dofs == ((radial - 1) * around + 1) * levels
    at_axis = np.linalg.norm(part.dof_positions[:, :2], axis=1) < 1e-12
    assert at_axis.sum() == levels
    assert len(np.unique(np.round(part.dof_positions, 9), axis=0)) == part.num_scalar_dofs


def test_mass_and_rigid_motions() -> None:
    part = body(DISC, (2, 16, 1), (2, 6, 2))
    K, M = scipy_of(part.stiffness()), scipy_of(part.mass())
    assert M.sum() == pytest.approx(3 * STEEL.rho * AREA * (TOP - BOTTOM), rel=1e-13)
    x = part.dof_positions
    for axis in np.eye(3):
        for motion in (np.broadcast_to(axis, x.shape), np.cross(axis, x)):
            residual = np.abs(K @ motion.ravel()).max()
            assert residual <= 1e-14 * abs(K).sum(axis=1).max() * np.abs(motion).max()
    small = body(DISC, (2, 8, 1), (2, 2, 2))
    values = eigh(scipy_of(small.stiffness()).toarray(), eigvals_only=True)
    assert values[5] < 1e-12 * values[-1] < values[6]


def test_surfaces() -> None:
    part = body(DISC, (3, 8, 2), (2, 3, 2))
    up = TILTED.rotation[:, 2]
    assert part.surfaces["outer"].area == pytest.approx(2 * np.pi * RADIUS * 0.3, rel=1e-13)
    for name, normal in (("top", up), ("bottom", -up)):
        surface = part.surfaces[name]
        assert surface.area == pytest.approx(AREA, rel=1e-13)
        greville = surface.abscissae("greville")
        assert len(greville) == len(surface.dofs) == 4 * 16 + 1
        matrix = surface.trace(greville.at).toarray()[:, surface.dofs]
        assert np.linalg.cond(matrix) < 100
        gauss = surface.gauss_points(3)
        for points in (gauss, greville, surface.grid(4)):
            np.testing.assert_allclose(points.normal, np.tile(normal, (len(points), 1)), atol=1e-9)
            assert np.abs(surface.trace(points.at) @ part.dof_positions - points.x).max() < 2e-15
            linear = part.dof_positions @ [0.3, -0.7, 1.1]
            for slope, along in zip([0.3, -0.7, 1.1], surface.gradient(points.at), strict=True):
                assert np.abs(along @ linear - slope).max() < 1e-8
        centre = np.array(TILTED.translation)
        assert np.linalg.norm(np.cross(gauss.x - centre, up), axis=1).min() > 1e-3


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


def test_pressure_on_the_top_has_its_resultant() -> None:
    part = body(DISC, (2, 12, 1), (2, 6, 2), pressures=[Pressure("top", 1.3)])
    force = part.load().getArray().reshape(-1, 3)
    resultant = -1.3 * AREA * TILTED.rotation[:, 2]
    np.testing.assert_allclose(force.sum(axis=0), resultant, rtol=1e-12, atol=1e-12)


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
    part = nurbs_body("disc", data.patches, {"outer": data.faces["outer"]}, (4, 4, 3),
                     material=material, supports=held)  # fmt: skip
    K, M = scipy_of(part.stiffness()).tocsc(), scipy_of(part.mass()).tocsc()
    kappa = np.sort(eigsh(K, 6, M, sigma=0, return_eigenvectors=False))
    rigidity = 2.0 * h**3 / (12 * (1 - 0.3**2))
    numbers = np.sqrt(kappa * 1.5 * h / rigidity)
    leissa = [10.2158, 21.26, 21.26, 34.88, 34.88, 39.771]
    np.testing.assert_allclose(numbers, leissa, rtol=1e-3)
    assert numbers[2] - numbers[1] < 1e-6 * numbers[1]
