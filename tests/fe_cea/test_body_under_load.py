"""Lagrange bodies under load: patch tests, supports, springs, pressures, first frequencies."""

import dolfinx
import numpy as np
import pytest
import scipy.sparse as sp
from bodies import dolfinx_body
from fe_shapes import (
    BOX,
    MATERIAL,
    box,
    coordinates,
)
from lagrange_bodies import csr
from mpi4py import MPI
from scipy.sparse.linalg import eigsh

from cea.supports.boundary import Support

"""And every degree, not all together: each has forms of its own, which take long to compile."""


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
