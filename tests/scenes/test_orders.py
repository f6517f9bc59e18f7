"""Eigenvalues converge with order 2q on both backends, on meshes that suit their edges.

Where two faces of a body meet, u ~ r^alpha with r the distance from their edge. Uniform meshes of
size 1/n then give errors of order min(2q, 2 alpha) in n. Meshes whose breaks crowd towards the
edge, at a distance (i / n)^beta from it, give order 2q again where beta > q / alpha (Babuska,
Kellogg and Pitkaranta, Numer. Math. 33, 1979). In plane strain with nu = 0.3 the smallest alpha at
a right angle is 2.74 between free faces, 1.42 between clamped ones and 0.71 between a clamped and a
free one (Williams, J. Appl. Mech. 19, 1952).

The blocks here are the eighth of a block, or the quarter of one, on rollers in its planes of
symmetry, where solutions are smooth: the modes that share these symmetries.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from bodies import lagrange_body, nurbs_body
from scipy.optimize import brentq
from scipy.special import jv, yv

from cea.material import IsotropicMaterial
from cea.supports.boundary import Support
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Box

pytestmark = pytest.mark.convergence
NU = 0.3
MATERIAL = IsotropicMaterial(E=1.0, nu=NU, rho=1.0)
SIZE = (0.5, 0.4, 0.3)
BLOCK = Box(SIZE)
PIPE = Annulus(0.5, 1.0, 0.0, 0.4)


def eigenvalue(body, near):
    """Eigenvalue of K x = kappa M x nearest to a value."""
    from slepc4py import SLEPc

    solver = SLEPc.EPS().create(body.comm)
    solver.setOperators(body.stiffness(), body.mass())
    solver.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    solver.setTarget(near)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    preconditioner = transform.getKSP().getPC()
    preconditioner.setType("cholesky")
    preconditioner.setFactorSolverType("mumps")
    solver.setTolerances(1e-13, 100)
    solver.solve()
    found = [solver.getEigenvalue(i).real for i in range(solver.getConverged())]
    solver.destroy()
    return min(found, key=lambda kappa: abs(kappa - near))


def body_of(backend, shape, breaks, degree, supports, order=None):
    """Body with given breaks, its geometry of the degree of its elements or of another order."""
    if backend == "iga":
        data = nurbs_shape(shape, breaks, Placement())
        return nurbs_body(
            "part",
            data.patches,
            data.faces,
            (degree,) * len(breaks),
            material=MATERIAL,
            supports=supports,
        )
    made = shape_mesh(shape, "hexahedron", order or degree, breaks=breaks)
    return lagrange_body("part", made, degree=degree, material=MATERIAL, supports=supports)


def assert_order(counts, errors, order, within=0.2):
    rate = -np.polyfit(np.log(counts), np.log(np.abs(errors)), 1)[0]
    assert rate == pytest.approx(order, abs=within), errors


def exponent(conditions):
    """Smallest alpha between 0.5 and 2 at a right angle, of Williams' characteristic equations."""
    k = 3 - 4 * NU
    right = {
        "clamped": lambda a: a**2 / k**2,
        "clamped and free": lambda a: (k + 1) ** 2 / (4 * k) - a**2 / k,
    }[conditions]
    start = {"clamped": 1.1, "clamped and free": 0.5}[conditions]
    return brentq(lambda a: np.sin(a * np.pi / 2) ** 2 - right(a), start, 1.9)


@dataclass(frozen=True)
class Block:
    """A part of a block on rollers in planes of symmetry, its eigenvalue, its smallest exponent."""

    supports: tuple
    kappa: float
    exponent: float

    def error(self, backend, q, n, grading):
        """Relative error with n elements a side, crowded towards the far faces."""
        crowded = 1 - (1 - np.linspace(0, 1, n + 1)) ** grading
        breaks = tuple(side * crowded for side in SIZE)
        body = body_of(backend, BLOCK, breaks, q, self.supports)
        return eigenvalue(body, self.kappa) / self.kappa - 1


ROLLERS = tuple(Support(f"{axis}_min", (i,)) for i, axis in enumerate("xyz"))
BLOCKS = {
    # Extrapolated from Legendre polynomials to degree 25 in each direction, 11 digits (Visscher
    # et al., J. Acoust. Soc. Am. 90, 1991).
    "free": Block(ROLLERS, 23.2437057055, 2.74),
    # Extrapolated from NURBS of degree 5 and 6 on meshes graded by 3.6 and 4.5, which agree to
    # 9 digits, and with Legendre polynomials of degree 23 to their 8.
    "clamped all round": Block(
        (*ROLLERS, *(Support(f"{axis}_max") for axis in "xyz")), 56.61267675, exponent("clamped")
    ),
    # Extrapolated from Lagrange elements of degree 4 on meshes graded by 5.6: 7 digits.
    "clamped on one face": Block(
        (*ROLLERS[:2], Support("z_max")), 15.0764685, exponent("clamped and free")
    ),
}

slow = pytest.mark.slow


@pytest.mark.parametrize(
    ("name", "backend", "q", "counts"),
    [
        ("free", "fe", 1, (6, 9, 12)),
        pytest.param("free", "fe", 2, (4, 6, 8), marks=slow),
        pytest.param("free", "fe", 3, (4, 5, 6), marks=slow),
        ("free", "iga", 2, (4, 6, 8)),
        pytest.param("free", "iga", 3, (5, 6, 8), marks=slow),
        pytest.param("free", "iga", 4, (5, 6, 8), marks=slow),
        ("clamped all round", "fe", 1, (6, 9, 12)),
        pytest.param("clamped all round", "fe", 2, (4, 6, 8), marks=slow),
        pytest.param("clamped all round", "fe", 3, (4, 5, 6), marks=slow),
        pytest.param("clamped all round", "iga", 2, (6, 8, 12), marks=slow),
        pytest.param("clamped all round", "iga", 3, (8, 9, 10), marks=slow),
        pytest.param("clamped on one face", "fe", 1, (12, 14, 16), marks=slow),
        pytest.param("clamped on one face", "iga", 2, (10, 12, 14), marks=slow),
    ],
)
def test_blocks_on_meshes_graded_to_their_edges(name, backend, q, counts):
    """Left out: what nears 2q on finer meshes only.

    NURBS of degree 4 clamped all round have order 7.3 to 7.7 with 8 to 12 elements a side; clamped
    on one face, quadratic Lagrange elements 3.6 and cubic NURBS 5.4 with 10 to 12.
    """
    block = BLOCKS[name]
    grading = max(1.0, 1.05 * q / block.exponent)
    errors = [block.error(backend, q, n, grading) for n in counts]
    assert_order(counts, errors, 2 * q)


def twist_of_the_pipe():
    """Lowest kappa of the pipe held at its inside and both ends, as it twists.

    u_theta = (a J1(k r) + b Y1(k r)) sin(pi z / h) vanishes at the inner radius, and the shear
    stress, as J2 and Y2, at the outer. Nothing is singular at an edge.
    """
    inner, outer, height = PIPE.inner_radius, PIPE.outer_radius, PIPE.top - PIPE.bottom

    def determinant(k):
        return jv(1, k * inner) * yv(2, k * outer) - yv(1, k * inner) * jv(2, k * outer)

    k = brentq(determinant, 0.5, 3.5, xtol=1e-15, rtol=1e-15)
    return MATERIAL.lame[1] / MATERIAL.rho * (k**2 + (np.pi / height) ** 2)


def pipe_error(backend, q, elements, order=None):
    held = [Support(name) for name in ("inner", "bottom", "top")]
    exact = twist_of_the_pipe()
    breaks = breaks_of(PIPE, elements)
    return eigenvalue(body_of(backend, PIPE, breaks, q, held, order), exact) / exact - 1


@pytest.mark.parametrize(
    ("backend", "q", "counts"),
    [
        ("fe", 1, (4, 6, 8)),
        pytest.param("fe", 2, (3, 4, 5), marks=slow),
        pytest.param("fe", 3, (2, 3, 4), marks=slow),
        pytest.param("iga", 2, (4, 6, 8), marks=slow),
        pytest.param("iga", 3, (6, 8, 10), marks=slow),
        pytest.param("iga", 4, (4, 6, 8), marks=slow),
    ],
)
def test_clamped_pipe(backend, q, counts):
    """The twist is exact around the axis for NURBS: any number of elements does there."""
    around = {"fe": 4, "iga": 2}[backend]
    errors = [pipe_error(backend, q, (n, around * n, n)) for n in counts]
    assert_order(counts, errors, 2 * q)
