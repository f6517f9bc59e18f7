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
SHEAR, BULK = MU / RHO, (LAM + 2 * MU) / RHO
"""Squares of the speeds of waves."""


def slow(*values):
    return pytest.param(*values, marks=pytest.mark.slow)


def sliding(shape):
    """Supports that let a box slide along its walls."""
    return [Support(name, (name[0],)) for name in shape.surfaces]


def torsion(inner, outer):
    """Kappa of a ring that turns about its held inner circle.

    The circumferential displacement is a J1(k r) + b Y1(k r) with k^2 = rho kappa / mu; it
    vanishes at the inner circle, and the shear stress, as J2 and Y2, at the outer.
    """

    def determinant(k):
        return jv(1, k * inner) * yv(2, k * outer) - yv(1, k * inner) * jv(2, k * outer)

    return SHEAR * brentq(determinant, 0.5, 3.5, xtol=1e-15, rtol=1e-15) ** 2


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

    return BULK * brentq(determinant, 5.5, 7.5, xtol=1e-15, rtol=1e-14) ** 2


PLATE, CUBE = Rectangle((1.3, 1.0)), Box((1.0, 1.0, 0.2))
FACES = [Support("outer", ("x", "y")), Support("bottom", ("z",)), Support("top", ("z",))]
BODIES = {
    # shape, supports, exact kappa, elements of n; shear waves between sliding walls
    "cube": (CUBE, sliding(CUBE), SHEAR * 2 * np.pi**2, lambda n: (n, n, 1)),
    "plate": (PLATE, sliding(PLATE), np.pi**2 * (1 / 1.3**2 + 1) * SHEAR, lambda n: (n, n)),
    "held ring": (
        Ring(0.5, 1.0),
        [Support("inner", ("x", "y"))],
        torsion(0.5, 1.0),
        lambda n: (n, 12 * n),
    ),
    "ring": (Ring(1.2, 1.7), [], breathing(1.2, 1.7), lambda n: (n, 4 * n)),
    # u_theta = J1(k r), rim held: the collapsed axis does not spoil the order
    "disc": (
        Disc(1.2, 0.0, 0.3),
        FACES,
        (jn_zeros(1, 1)[0] / 1.2) ** 2 * SHEAR,
        lambda n: (n, 2 * n + 2 * n % 4, 1),
    ),
}


def error(name, cell, degree, n, order=None):
    """Relative error of the eigenvalue nearest to the exact one."""
    shape, supports, exact, elements = BODIES[name]
    body = shape_body(shape, cell, degree, elements(n), order=order, supports=supports)
    K, M = to_scipy(body.stiffness()).tocsc(), to_scipy(body.mass()).tocsc()
    found = eigsh(K, k=8, M=M, sigma=0.999 * exact, return_eigenvectors=False, tol=1e-14)
    return np.abs(found / exact - 1).min()


def rate(errors, counts):
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


@pytest.mark.parametrize(
    ("degree", "n", "within", "least"),
    [(1, 6, 0.2, 1e-2), (2, 6, 0.2, 3e-7), slow(3, 6, 0.2, 3e-10), slow(4, 3, 0.4, 5e-11)],
)
def test_curved_lagrange_rings_converge_like_h_to_2q(degree, n, within, least):
    """Cubic arcs through equispaced points rather than Lobatto points would stop at fourth order.

    Degree 4 meets rounding before its rate is quite reached.
    """
    coarse, fine = (error("held ring", "quadrilateral", degree, m) for m in (n, 2 * n))
    assert fine < least
    assert np.log2(coarse / fine) == pytest.approx(2 * degree, abs=within)


@pytest.mark.parametrize(
    ("name", "cell", "degree", "n"),
    [
        *(("plate", "quadrilateral", *row) for row in ((1, 8), (2, 4), (3, 3))),
        *(("cube", "hexahedron", *row) for row in ((1, 8), (2, 4), (3, 2))),
        *(("cube", "tetrahedron", *row) for row in ((1, 8), (2, 4))),
    ],
)
def test_lagrange_boxes_between_sliding_walls_converge_like_h_to_2q(name, cell, degree, n):
    errors = [error(name, cell, degree, m, order=1) for m in (n, 2 * n)]
    assert rate(errors, (n, 2 * n)) == pytest.approx(2 * degree, abs=0.2)


@pytest.mark.parametrize(
    ("name", "q", "least"),
    [
        *(("plate", 2, 2e-5), ("plate", 3, 1e-7), ("plate", 4, 3e-10)),
        *(("cube", 2, 2e-5), slow("cube", 3, 1e-7)),
        *(("ring", 2, 1e-5), slow("ring", 3, 2e-8), slow("ring", 4, 5e-11)),
        *(("disc", 2, 1e-5), slow("disc", 3, 1e-7)),
    ],
)
def test_nurbs_bodies_converge_like_h_to_2q(name, q, least):
    counts = {2: (6, 12), 3: (6, 12), 4: (8, 12)}[q]
    degree = (q, q, 1) if name in ("disc", "cube") else q
    errors = [error(name, None, degree, n) for n in counts]
    assert rate(errors, counts) == pytest.approx(2 * q, abs=0.2)
    assert errors[-1] < least
