"""Rates at which eigenvalues of Lagrange bodies converge: 2q, and 2 on straight-sided rings."""

import numpy as np
import pytest
import scipy.sparse as sp
from bodies import lagrange_body
from scipy.optimize import brentq
from scipy.sparse.linalg import eigsh
from scipy.special import jv, yv

from cea.material import IsotropicMaterial
from cea.supports.boundary import Support
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Box, Rectangle, Ring

pytestmark = pytest.mark.convergence
MATERIAL = IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
RING = Ring(0.5, 1.0)


def slow(*values):
    return pytest.param(*values, marks=pytest.mark.slow)


def torsion_of_the_ring():
    """Square of the angular frequency of the ring turning about its held inner circle.

    The circumferential displacement is a J1(k r) + b Y1(k r) with k^2 = rho omega^2 / mu; it
    vanishes at the inner circle, and the shear stress, as J2 and Y2, at the outer.
    """

    def determinant(k):
        a, b = RING.inner_radius, RING.outer_radius
        return jv(1, k * a) * yv(2, k * b) - yv(1, k * a) * jv(2, k * b)

    k = brentq(determinant, 0.5, 3.5, xtol=1e-15, rtol=1e-15)
    return MATERIAL.lame[1] / MATERIAL.rho * k**2


def csr(matrix):
    starts, columns, values = matrix.getValuesCSR()
    return sp.csr_array((values, columns, starts), shape=matrix.getSize())


def error(shape, cell, degree, order, exact, supports, **mesh):
    """Relative error of the eigenvalue nearest to an exact one."""
    made = shape_mesh(shape, cell, order, **mesh)
    body = lagrange_body("part", made, degree=degree, material=MATERIAL, supports=supports)
    K, M = csr(body.stiffness()).tocsc(), csr(body.mass()).tocsc()
    found = eigsh(K, k=4, M=M, sigma=0.999 * exact, return_eigenvectors=False, tol=1e-14)
    return np.abs(found / exact - 1).min()


def ring_error(cell, degree, order, n):
    mesh = {"size": 0.5 / n}
    if cell != "triangle":
        mesh = {"breaks": breaks_of(RING, (n, 12 * n))}
        cell = {"divided quadrilateral": "triangle"}.get(cell, cell)
    held = [Support("inner", (0, 1))]
    return error(RING, cell, degree, order, torsion_of_the_ring(), held, **mesh)


@pytest.mark.parametrize(
    ("degree", "n", "within"), [(1, 6, 0.2), (2, 6, 0.2), slow(3, 6, 0.2), slow(4, 3, 0.4)]
)
def test_curved_rings_converge_like_h_to_2q(degree, n, within):
    """Cubic arcs through equispaced points rather than Lobatto points would stop at fourth order.

    Degree 4 meets rounding before its rate is quite reached.
    """
    coarse, fine = (ring_error("quadrilateral", degree, degree, m) for m in (n, 2 * n))
    assert fine < {1: 1e-2, 2: 3e-7, 3: 3e-10, 4: 5e-11}[degree]
    assert np.log2(coarse / fine) == pytest.approx(2 * degree, abs=within)


@pytest.mark.parametrize("degree", [2, slow(3)])
def test_straight_rings_stop_at_second_order(degree):
    coarse, fine = (ring_error("quadrilateral", degree, 1, n) for n in (4, 8))
    assert np.log2(coarse / fine) == pytest.approx(2, abs=0.2)
    assert fine > 100 * ring_error("quadrilateral", degree, degree, 8)


def sliding(shape):
    """Supports that let a box slide along its walls: the shear wave of wave vector (pi, pi)."""
    return [Support(name, ("xyz".index(name[0]),)) for name in shape.surfaces]


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
def test_boxes_between_sliding_walls_converge_like_h_to_2q(cell, degree, n):
    shape = Rectangle((1.0, 1.0)) if cell == "quadrilateral" else Box((1.0, 1.0, 0.2))
    exact = MATERIAL.lame[1] / MATERIAL.rho * 2 * np.pi**2
    coarse, fine = (
        error(
            shape,
            cell,
            degree,
            1,
            exact,
            sliding(shape),
            breaks=breaks_of(shape, (m, m, 1)[: len(shape.directions)]),
        )
        for m in (n, 2 * n)
    )
    assert np.log2(coarse / fine) == pytest.approx(2 * degree, abs=0.2)
