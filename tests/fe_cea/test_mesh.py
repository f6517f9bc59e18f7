"""Bodies on meshes written out by hand, and as gmsh makes them."""

import doctest

import gmsh
import pytest
from bodies import lagrange_body
from lagrange_bodies import MATERIAL
from mpi4py import MPI

import cea.body.body
from cea.body import Body
from cea.errors import InputError
from cea.mesh import Mesh
from meshes.unstructured import gmsh_session, read_gmsh


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
