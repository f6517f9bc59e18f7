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


ROWS = [
    # body, cell or None of NURBS, degree, elements, bound of the error on the finer mesh
    ("ring", "quadrilateral", 2, (6, 12), 7e-6),
    slow("ring", "quadrilateral", 3, (3, 6), 2e-7),
    slow("ring", "quadrilateral", 4, (3, 6), 3e-10),
    *(("plate", "quadrilateral", q, (n, 2 * n), np.inf) for q, n in ((1, 8), (2, 4), (3, 3))),
    *(("cube", "hexahedron", q, (n, 2 * n), np.inf) for q, n in ((1, 8), (2, 4), (3, 2))),
    *(("cube", "tetrahedron", q, (n, 2 * n), np.inf) for q, n in ((1, 8), (2, 4))),
    *(("plate", None, 2, (6, 12), 2e-5), ("plate", None, 3, (6, 12), 1e-7)),
    ("plate", None, 4, (8, 12), 3e-10),
    *(("cube", None, 2, (6, 12), 2e-5), slow("cube", None, 3, (6, 12), 1e-7)),
    *(("ring", None, 2, (6, 12), 1e-5), slow("ring", None, 3, (6, 12), 2e-8)),
    slow("ring", None, 4, (8, 12), 5e-11),
    *(("disc", None, 2, (6, 12), 1e-5), slow("disc", None, 3, (6, 12), 1e-7)),
]


@pytest.mark.parametrize(("name", "cell", "degree", "counts", "least"), ROWS)
def test_eigenvalues_converge_like_h_to_2q(name, cell, degree, counts, least):
    """Cubic arcs through equispaced points rather than Lobatto points would stop at fourth order.

    The cells of boxes are straight, whatever the degree of functions on them.
    """
    order = 1 if cell and name != "ring" else None
    degrees = (degree, degree, 1) if cell is None and name in ("disc", "cube") else degree
    coarse, fine = (error(name, cell, degrees, n, order=order) for n in counts)
    assert fine < least
    rate = np.log(coarse / fine) / np.log(counts[1] / counts[0])
    assert rate == pytest.approx(2 * degree, abs=0.2)
