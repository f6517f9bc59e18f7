"""Eigenvalues of bodies of both backends converge at twice the degree to closed forms."""

import numpy as np
import pytest
from bodies import PLASTIC, shape_body
from petsc_matrices import to_scipy
from scipy.optimize import brentq
from scipy.sparse.linalg import eigsh
from scipy.special import jn_zeros, jv, jvp, yv, yvp

from cea.supports.boundary import Support
from meshes.shapes import Box, Disc, Rectangle, Ring

pytestmark = pytest.mark.convergence
LAM, MU = PLASTIC.lame
RHO = 1.5


def slow(*values):
    return pytest.param(*values, marks=pytest.mark.slow)


def error(body, exact):
    """Relative error of the eigenvalue nearest to an exact one."""
    K, M = to_scipy(body.stiffness()).tocsc(), to_scipy(body.mass()).tocsc()
    sigma = 0.999 * exact
    found = eigsh(K, k=8, M=M, sigma=sigma, return_eigenvectors=False, tol=1e-14)
    return np.abs(found / exact - 1).min()


def sliding(shape):
    """Supports that let a box slide along its walls."""
    return [Support(name, ("xyz".index(name[0]),)) for name in shape.surfaces]


def rate(errors, counts):
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


RING = Ring(0.5, 1.0)


def torsion_of_the_ring():
    """Square of the angular frequency of the ring turning about its held inner circle.

    The circumferential displacement is a J1(k r) + b Y1(k r) with k^2 = rho omega^2 / mu; it
    vanishes at the inner circle, and the shear stress, as J2 and Y2, at the outer.
    """

    def determinant(k):
        a, b = RING.inner_radius, RING.outer_radius
        return jv(1, k * a) * yv(2, k * b) - yv(1, k * a) * jv(2, k * b)

    k = brentq(determinant, 0.5, 3.5, xtol=1e-15, rtol=1e-15)
    return MU / RHO * k**2


def ring_error(degree, order, n):
    held = [Support("inner", (0, 1))]
    mesh = (n, 12 * n)
    body = shape_body(RING, "quadrilateral", degree, mesh, order=order, supports=held)
    return error(body, torsion_of_the_ring())


@pytest.mark.parametrize(
    ("degree", "n", "within"), [(1, 6, 0.2), (2, 6, 0.2), slow(3, 6, 0.2), slow(4, 3, 0.4)]
)
def test_curved_lagrange_rings_converge_like_h_to_2q(degree, n, within):
    """Cubic arcs through equispaced points rather than Lobatto points would stop at fourth order.

    Degree 4 meets rounding before its rate is quite reached.
    """
    coarse, fine = (ring_error(degree, degree, m) for m in (n, 2 * n))
    assert fine < {1: 1e-2, 2: 3e-7, 3: 3e-10, 4: 5e-11}[degree]
    assert np.log2(coarse / fine) == pytest.approx(2 * degree, abs=within)


@pytest.mark.parametrize("degree", [2, slow(3)])
def test_straight_lagrange_rings_stop_at_second_order(degree):
    coarse, fine = (ring_error(degree, 1, n) for n in (4, 8))
    assert np.log2(coarse / fine) == pytest.approx(2, abs=0.2)
    assert fine > 100 * ring_error(degree, degree, 8)


@pytest.mark.parametrize(
    ("cell", "degree", "n"),
    [
        ("quadrilateral", 1, 8),
        ("quadrilateral", 2, 4),
        ("quadrilateral", 3, 3),
        ("hexahedron", 1, 8),
        ("hexahedron", 2, 4),
        ("hexahedron", 3, 2),
        ("tetrahedron", 1, 8),
        ("tetrahedron", 2, 4),
    ],
)
def test_lagrange_boxes_between_sliding_walls_converge_like_h_to_2q(cell, degree, n):
    """The shear wave of wave vector (pi, pi)."""
    shape = Rectangle((1.0, 1.0)) if cell == "quadrilateral" else Box((1.0, 1.0, 0.2))
    counts = (n, 2 * n)
    errors = []
    for m in counts:
        mesh = (m, m, 1)[: len(shape.directions)]
        body = shape_body(shape, cell, degree, mesh, order=1, supports=sliding(shape))
        errors.append(error(body, MU / RHO * 2 * np.pi**2))
    assert rate(errors, counts) == pytest.approx(2 * degree, abs=0.2)


def breathing(inner, outer):
    """Second kappa of a free ring in plane strain that moves along its radius only.

    u_r = A J1(k r) + B Y1(k r) with sigma_rr = 0 at both rims.
    """

    def determinant(k):
        stress = [
            [(LAM + 2 * MU) * k * slope(1, k * r) + LAM / r * f(1, k * r) for r in (inner, outer)]
            for f, slope in ((jv, jvp), (yv, yvp))
        ]
        return float(np.linalg.det(stress))

    k = brentq(determinant, 5.5, 7.5, xtol=1e-15, rtol=1e-14)
    return k**2 * (LAM + 2 * MU) / RHO


PLATE, BLOCK, DISC = Rectangle((1.3, 1.0)), Box((1.3, 1.0, 0.9)), Disc(1.2, 0.0, 0.3)
NURBS = {
    # u = curl cos(pi x / a) cos(pi y / b)
    "plate": (PLATE, sliding(PLATE), np.pi**2 * (1 / 1.3**2 + 1) * MU / RHO),
    # u = grad cos(pi x / a) cos(pi y / b) cos(pi z / c)
    "block": (BLOCK, sliding(BLOCK), np.pi**2 * (1 / 1.3**2 + 1 + 1 / 0.81) * (LAM + 2 * MU) / RHO),
    "ring": (Ring(1.2, 1.7), [], breathing(1.2, 1.7)),
    # u_theta = J1(k r), rim held: the collapsed axis does not spoil the order
    "disc": (
        DISC,
        [Support("outer", (0, 1)), Support("bottom", (2,)), Support("top", (2,))],
        (jn_zeros(1, 1)[0] / 1.2) ** 2 * MU / RHO,
    ),
}
ELEMENTS = {
    "plate": lambda n: (n, n),
    "block": lambda n: (n, n, n),
    "ring": lambda n: (n, 4 * n),
    "disc": lambda n: (n, 2 * n + 2 * n % 4, 1),
}


@pytest.mark.parametrize(
    ("case", "q", "least"),
    [
        ("plate", 2, 2e-5),
        ("plate", 3, 1e-7),
        ("plate", 4, 3e-10),
        ("block", 2, 5e-4),
        slow("block", 3, 3e-6),
        ("ring", 2, 1e-5),
        slow("ring", 3, 2e-8),
        slow("ring", 4, 5e-11),
        ("disc", 2, 1e-5),
        slow("disc", 3, 1e-7),
    ],
)
def test_nurbs_bodies_converge_like_h_to_2q(case, q, least):
    shape, supports, exact = NURBS[case]
    counts = (4, 6) if case == "block" else {2: (6, 8, 12), 3: (6, 8, 12), 4: (8, 10, 12)}[q]
    degree = (q, q, 1) if case == "disc" else (q,) * len(shape.directions)
    errors = [
        error(shape_body(shape, None, degree, ELEMENTS[case](n), supports=supports), exact)
        for n in counts
    ]
    # So coarse, the next terms of the error of the block still raise the rate.
    assert 2 * q - 0.2 < rate(errors, counts) < 2 * q + (0.5 if case == "block" else 0.2)
    assert errors[-1] < least
