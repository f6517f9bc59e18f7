"""Lagrange bodies: a mass by hand, meshes written out and as gmsh makes them; refusals."""

import doctest

import dolfinx
import gmsh
import numpy as np
import pytest
from bodies import dolfinx_body, lagrange_body
from lagrange_bodies import FLAT, MATERIAL
from mpi4py import MPI
from petsc_matrices import to_scipy

import cea.body.body
from cea.body import Body
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.mesh import Mesh, reference_nodes
from meshes.shape_mesh import shape_mesh
from meshes.unstructured import gmsh_session, read_gmsh


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
        degree: to_scipy(
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


def test_models_that_are_no_mesh_of_one_kind_are_refused():
    with gmsh_session():
        gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
        gmsh.model.occ.synchronize()
        with pytest.raises(InputError, match="no nodes"):
            read_gmsh(gmsh.model)
        gmsh.model.mesh.generate(2)
        assert read_gmsh(gmsh.model).surfaces == {}
        nodes = gmsh.model.mesh.getNodes()[0][:4]
        quadrangle = gmsh.model.mesh.getElementType("Quadrangle", 1)
        gmsh.model.mesh.addElementsByType(1, quadrangle, [], nodes)
        with pytest.raises(InputError, match=r"of one kind.*Quadrilateral 4, Triangle 3"):
            read_gmsh(gmsh.model)


def test_the_example_of_the_docstring_runs():
    tests = doctest.DocTestFinder().find(Body, globs=vars(cea.body.body))
    results = [doctest.DocTestRunner().run(test) for test in tests if test.examples]
    assert [(r.failed, r.attempted > 4) for r in results] == [(0, True)]


def test_no_mesh_and_inverted_cells_are_refused():
    with pytest.raises(InputError, match=r"^bodies\.part\.mesh = None"):
        lagrange_body("part", None, degree=1, material=MATERIAL)
    square = [[0, 0], [1, 0], [0, 1], [1, 1]]
    crossed = Mesh("quadrilateral", 1, square, [[0, 1, 3, 2]], {})
    with pytest.raises(InputError, match=r"^bodies\.part\.mesh = '1 of 1 cells'"):
        lagrange_body("part", crossed, degree=1, material=MATERIAL, comm=MPI.COMM_SELF)


def test_points_of_no_cell_are_left_aside():
    square = [[0, 0], [77.0, 0], [1, 0], [0, 1], [1, 1]]
    mesh = Mesh("quadrilateral", 1, square, [[0, 3, 2, 4]], {"low": [[0, 2]]})
    body = lagrange_body("part", mesh, degree=2, material=MATERIAL, comm=MPI.COMM_SELF)
    assert body.num_scalar_dofs == 9
    assert body.surfaces["low"].area == pytest.approx(1.0)
