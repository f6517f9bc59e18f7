"""Lagrange bodies under load: patch tests, supports, springs, pressures, first frequencies."""

import dolfinx
import numpy as np
import pytest
import scipy.sparse as sp
from bodies import dolfinx_body
from covering import covering
from fe_shapes import (
    ANNULUS,
    BOX,
    MATERIAL,
    annulus,
    box,
    coordinates,
    exact_measures,
)
from lagrange_bodies import csr
from mpi4py import MPI
from scipy.sparse.linalg import eigsh, spsolve

from cea.supports.boundary import Pressure, Spring, Support

every_cell = pytest.mark.parametrize(
    ("cell", "degree"), covering(("tetrahedron", "hexahedron"), (1, 2), strength=1)
)
"""And every degree, not all together: each has forms of its own, which take long to compile."""


@every_cell
def test_patch_test_under_pressure(cell, degree):
    p = 0.07
    rollers = [Support(f"{axis}_min", (i,)) for i, axis in enumerate("xyz")]
    body = box(cell, degree, supports=rollers, pressures=[Pressure("z_max", p)])
    expand = csr(body.expansion)
    u = expand @ spsolve(csr(body.stiffness()).tocsc(), body.load().getArray())
    x = coordinates(body, degree) - BOX.origin
    exact = p / MATERIAL.E * x * [MATERIAL.nu, MATERIAL.nu, -1.0]
    np.testing.assert_allclose(u.reshape(-1, 3), exact, atol=1e-13)


def test_expansion_holds_the_supports_and_nothing_else():
    body = box("hexahedron", 2, supports=[Support("x_min", (0, 2)), Support("z_max", (1,))])
    expand = csr(body.expansion)
    x = coordinates(body, 2)
    held = np.zeros(x.shape, dtype=bool)
    held[np.isclose(x[:, 0], BOX.extent[0][0])] |= [True, False, True]
    held[np.isclose(x[:, 2], BOX.extent[2][1])] |= [False, True, False]
    assert np.array_equal(expand.sum(axis=1), ~held.ravel())
    assert abs(expand.T @ expand - sp.eye_array(expand.shape[1])).max() == 0
    free = box("hexahedron", 2)
    for part, whole in (
        (body.stiffness(), free.stiffness()),
        (body.mass(), free.mass()),
    ):
        reduced = expand.T @ csr(whole) @ expand
        assert part.getSize() == reduced.shape
        assert abs(csr(part) - reduced).max() == 0


@every_cell
def test_springs_resist_a_translation_by_area_times_stiffness(cell, degree):
    springs = [Spring("outer", (3.0, 5.0, 7.0)), Spring("top", (0.0, 0.0, 2.0))]
    body = annulus(cell, degree, springs=springs)
    outer, top = body.surfaces["outer"].area, body.surfaces["top"].area
    ones = np.ones(body.num_scalar_dofs)
    K = csr(body.stiffness())
    response = np.array([[ones @ K[i::3, j::3] @ ones for j in range(3)] for i in range(3)])
    expected = np.diag([3 * outer, 5 * outer, 7 * outer + 2 * top])
    np.testing.assert_allclose(response, expected, rtol=1e-5, atol=1e-11)


@every_cell
def test_pressure_pushes_along_the_inward_normal(cell, degree):
    """Resultant on the flat top; on the cylinder none, but a virial p r A."""
    p = 0.2
    top = annulus(cell, degree, pressures=[Pressure("top", p)])
    force = top.load().getArray().reshape(-1, 3).sum(axis=0)
    np.testing.assert_allclose(force, [0, 0, -p * top.surfaces["top"].area], atol=1e-12)
    inner = annulus(cell, degree, pressures=[Pressure("inner", p)])
    force = inner.load().getArray().reshape(-1, 3)
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-12)
    virial = (force[:, :2] * coordinates(inner, degree)[:, :2]).sum()
    exact = p * ANNULUS.inner_radius * exact_measures(ANNULUS)["inner"]
    assert virial == pytest.approx(exact, rel={1: 0.1, 2: 1e-3}[degree])


def test_no_pressure_is_no_load():
    body = box("hexahedron", 1, supports=[Support("x_min", (0, 1, 2))])
    assert body.load().getSize() == body.stiffness().getSize()[0]
    assert body.load().norm() == 0


def sliding_box(cell, degree, n):
    """Flat box n x n x 1 that slides freely along its six walls."""
    cell_type = dolfinx.mesh.CellType[cell]
    corners = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.2]]
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, corners, [n, n, 1], cell_type)
    mesh.topology.create_connectivity(2, 3)
    facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    middle = dolfinx.mesh.compute_midpoints(mesh, 2, facets)
    walls = [(i, level) for i in range(3) for level in (0.0, corners[1][i])]
    values = np.zeros(len(facets), dtype=np.int32)
    for tag, (i, level) in enumerate(walls, start=1):
        values[np.isclose(middle[:, i], level)] = tag
    tags = dolfinx.mesh.meshtags(mesh, 2, facets, values)
    names = {f"{'xyz'[i]}{level}": tag for tag, (i, level) in enumerate(walls, start=1)}
    rollers = [Support(name, ("xyz".index(name[0]),)) for name in names]
    return dolfinx_body(
        "box", mesh, tags, names, degree=degree, material=MATERIAL, supports=rollers
    )


@pytest.mark.parametrize(
    ("cell", "degree", "divisions"),
    [
        ("tetrahedron", 1, (12, 24)),
        ("tetrahedron", 2, (6, 12)),
        ("hexahedron", 1, (6, 12)),
        ("hexahedron", 2, (4, 8)),
    ],
)
def test_first_frequency_converges_like_h_to_2q(cell, degree, divisions):
    """Lowest mode between sliding walls: the shear wave of wave vector (pi, pi, 0)."""
    exact = MATERIAL.lame[1] / MATERIAL.rho * 2 * np.pi**2
    errors = []
    for n in divisions:
        body = sliding_box(cell, degree, n)
        K, M = csr(body.stiffness()), csr(body.mass())
        lowest = eigsh(K.tocsc(), k=1, M=M.tocsc(), sigma=0, return_eigenvectors=False)[0]
        errors.append(lowest / exact - 1)
    assert 0 < errors[1] < {1: 0.02, 2: 2e-4}[degree]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2 * degree, abs=0.2)
