"""Eigenvalues of smooth problems converge at twice the degree."""

import numpy as np
import pytest
from iga_data import body, scipy_of
from scipy.optimize import brentq
from scipy.sparse.linalg import eigsh
from scipy.special import jn_zeros, jv, jvp, yv, yvp

from cea.body import Body
from cea.material import IsotropicMaterial
from cea.supports.boundary import Support
from meshes.placement import Placement
from meshes.shapes import Box, Disc, Rectangle, Ring

pytestmark = pytest.mark.convergence
MATERIAL = IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
LAM, MU = MATERIAL.lame
RHO = 1.5
INNER, OUTER = 1.2, 1.7
FINENESS = {2: (6, 8, 12), 3: (6, 8, 12), 4: (8, 10, 12)}
"""Elements along the first direction, by degree."""


def rollers(shape) -> list[Support]:
    """Every face of a box held along its normal."""
    return [Support(name, ("xyz".index(name[0]),)) for name in shape.surfaces]


def error(part: Body, exact: float) -> float:
    """Relative error of the eigenvalue nearest an exact one."""
    K, M = scipy_of(part.stiffness()).tocsc(), scipy_of(part.mass()).tocsc()
    values = eigsh(K, 8, M, sigma=exact * 1.0001, return_eigenvectors=False)
    return np.abs(values / exact - 1).min()


def assert_order(errors: list[float], q: int, largest_last: float) -> None:
    rate = -np.polyfit(np.log(FINENESS[q]), np.log(errors), 1)[0]
    assert rate == pytest.approx(2 * q, abs=0.2)
    assert errors[-1] < largest_last


@pytest.mark.parametrize("q", [2, 3, 4])
def test_rectangle_on_rollers(q: int) -> None:
    """Shear mode u = curl cos(pi x / a) cos(pi y / b): kappa = mu / rho k^2."""
    shape = Rectangle((1.3, 1.0))
    exact = np.pi**2 * (1 / 1.3**2 + 1) * MU / RHO
    errors = [
        error(
            body(shape, (n, n), (q, q), Placement(), material=MATERIAL, supports=rollers(shape)),
            exact,
        )
        for n in FINENESS[q]
    ]
    assert_order(errors, q, {2: 2e-5, 3: 1e-7, 4: 3e-10}[q])


@pytest.mark.parametrize("q", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_box_on_rollers(q: int) -> None:
    """Dilatation u = grad cos(pi x / a) cos(pi y / b) cos(pi z / c)."""
    shape = Box((1.3, 1.0, 0.9))
    exact = np.pi**2 * (1 / 1.3**2 + 1 + 1 / 0.81) * (LAM + 2 * MU) / RHO
    errors = [
        error(
            body(
                shape, (n,) * 3, (q,) * 3, Placement(), material=MATERIAL, supports=rollers(shape)
            ),
            exact,
        )
        for n in (4, 6)
    ]
    rate = np.log(errors[0] / errors[1]) / np.log(6 / 4)
    # So coarse, the next terms of the error still raise the rate.
    assert 2 * q - 0.2 < rate < 2 * q + 0.5
    assert errors[-1] < {2: 5e-4, 3: 3e-6}[q]


def breathing(inner: float, outer: float) -> float:
    """Second kappa of a free ring in plane strain that moves along its radius only.

    u_r = A J1(k r) + B Y1(k r) with sigma_rr = 0 at both rims.
    """

    def determinant(k: float) -> float:
        stress = [
            [(LAM + 2 * MU) * k * slope(1, k * r) + LAM / r * f(1, k * r) for r in (inner, outer)]
            for f, slope in ((jv, jvp), (yv, yvp))
        ]
        return float(np.linalg.det(stress))

    k = brentq(determinant, 5.5, 7.5, xtol=1e-15, rtol=1e-14)
    return k**2 * (LAM + 2 * MU) / RHO


@pytest.mark.parametrize("q", [2, *(pytest.param(q, marks=pytest.mark.slow) for q in (3, 4))])
def test_free_ring(q: int) -> None:
    exact = breathing(INNER, OUTER)
    errors = [
        error(body(Ring(INNER, OUTER), (n, 4 * n), (q, q), material=MATERIAL), exact)
        for n in FINENESS[q]
    ]
    assert_order(errors, q, {2: 1e-5, 3: 2e-8, 4: 5e-11}[q])


@pytest.mark.parametrize("q", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_twisting_disc(q: int) -> None:
    """u_theta = J1(k r), rim held: the collapsed axis does not spoil the order."""
    held = [Support("outer", (0, 1)), Support("bottom", (2,)), Support("top", (2,))]
    exact = (jn_zeros(1, 1)[0] / 1.2) ** 2 * MU / RHO
    errors = [
        error(
            body(
                Disc(1.2, 0.0, 0.3),
                (n, 2 * n + 2 * n % 4, 1),
                (q, q, 1),
                material=MATERIAL,
                placement=Placement(),
                supports=held,
            ),
            exact,
        )
        for n in FINENESS[q]
    ]
    assert_order(errors, q, {2: 1e-5, 3: 1e-7}[q])
