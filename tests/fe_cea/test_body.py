"""Lagrange bodies: matrices against closed forms and slow independent assembly; refusals."""

import dolfinx
import numpy as np
import pytest
from bodies import dolfinx_body, lagrange_body
from lagrange_bodies import FLAT, MATERIAL, csr
from mpi4py import MPI

from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.mesh import reference_nodes
from meshes.shape_mesh import shape_mesh


def quadratic(at, place):
    """Quadratic function of the node of a place, at barycentric coordinates."""
    corner = at[place.argmax()]
    return corner * (2 * corner - 1) if place.max() == 2 else 4 * at[place == 1].prod()


def test_another_quadrature_of_the_mass_has_its_points():
    """Four points of degree 2 in each tetrahedron, by hand; the default is exact."""
    mesh = shape_mesh(FLAT[3], "tetrahedron", 2, size=0.7)
    a, b = (5 - np.sqrt(5)) / 20, (5 + 3 * np.sqrt(5)) / 20
    barycentric = np.full((4, 4), a) + (b - a) * np.eye(4)
    places = np.rint(2 * reference_nodes("tetrahedron", 2)).astype(int)
    weights = np.column_stack([2 - places.sum(axis=1), places])
    shapes = np.array([[quadratic(at, w) for w in weights] for at in barycentric])
    corners = [int(np.flatnonzero(weights[:, i] == 2)[0]) for i in range(4)]
    expected = np.zeros((len(mesh.points),) * 2)
    for cell in mesh.cells:
        x = mesh.points[cell[corners]]
        volume = abs(np.linalg.det(x[1:] - x[0])) / 6
        expected[np.ix_(cell, cell)] += MATERIAL.rho * volume / 4 * shapes.T @ shapes
    masses = {
        degree: csr(
            lagrange_body("part", mesh, degree=2, material=MATERIAL, mass_quadrature=degree).mass()
        )
        for degree in (None, 2, 4)
    }
    assert np.linalg.eigvalsh(masses[2].toarray()[::3, ::3]) == pytest.approx(
        np.linalg.eigvalsh(expected), abs=1e-14
    )
    assert abs(masses[4] - masses[None]).max() < 1e-14 < 1e-4 < abs(masses[2] - masses[None]).max()
    assert masses[2].sum() == pytest.approx(masses[None].sum())
    with pytest.raises(InputError, match="mass_quadrature"):
        lagrange_body("part", mesh, degree=2, material=MATERIAL, mass_quadrature=-1)


def test_a_tag_without_facets_is_refused():
    mesh = dolfinx.mesh.create_unit_cube(MPI.COMM_WORLD, 1, 1, 1)
    mesh.topology.create_connectivity(2, 3)
    facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    tags = dolfinx.mesh.meshtags(mesh, 2, facets, np.ones(len(facets), dtype=np.int32))
    with pytest.raises(InputError, match=r"bodies\.cube\.surfaces\.lid = 2"):
        dolfinx_body("cube", mesh, tags, {"all": 1, "lid": 2}, degree=1, material=MATERIAL)


def test_mass_needs_a_density():
    mesh = shape_mesh(FLAT[3], "tetrahedron", 1, size=1.0)
    body = lagrange_body("part", mesh, degree=1, material=IsotropicMaterial(1.0, 0.3))
    with pytest.raises(InputError, match=r"bodies\.part\.material\.rho = None: a density"):
        body.mass()
