"""Bodies on meshes written out by hand, and as gmsh makes them."""

import doctest

import gmsh
import numpy as np
import pytest
from bodies import lagrange_body
from lagrange_bodies import MATERIAL, csr
from mpi4py import MPI
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve

import cea.body.body
from cea.body import Body
from cea.errors import InputError
from cea.mesh import Mesh
from meshes.unstructured import gmsh_session, read_gmsh

CORNERS = {
    "triangle": [[0.0, 0.0], [1.0, 0.1], [0.9, 1.2], [-0.1, 1.0]],
    "quadrilateral": [[0.0, 0.0], [1.0, 0.1], [2.1, 0.0], [0.0, 1.0], [0.9, 1.2], [2.0, 1.0]],
    "tetrahedron": [[0.0, 0, 0], [1.0, 0.1, 0], [0.1, 1.0, 0], [0, 0.1, 1.0], [0.9, 0.8, 1.1]],
    "hexahedron": [
        [x + 0.1 * y * z, y - 0.1 * x * z, z + 0.2 * y] for x in (0, 1, 2) for y in (0, 1)
        for z in (0, 1)
    ],
}  # fmt: skip
"""Corners of two distorted cells."""

GMSH = {
    "triangle": ("Triangle", [[0, 1, 2], [2, 3, 0]], "Line", [[1, 2]]),
    "quadrilateral": ("Quadrangle", [[0, 1, 4, 3], [1, 2, 5, 4]], "Line", [[0, 1], [1, 2]]),
    "tetrahedron": ("Tetrahedron", [[0, 1, 2, 3], [1, 2, 3, 4]], "Triangle", [[0, 1, 2]]),
    "hexahedron": (
        "Hexahedron",
        [[0, 4, 6, 2, 1, 5, 7, 3], [4, 8, 10, 6, 5, 9, 11, 7]],
        "Quadrangle",
        [[0, 4, 6, 2], [4, 8, 10, 6]],
    ),
}
"""Cells, and facets of the surface ``side``, as gmsh lists their corners."""

ORDERED = {
    "triangle": [[0, 1, 2], [2, 3, 0]],
    "quadrilateral": [[0, 3, 1, 4], [1, 4, 2, 5]],
    "tetrahedron": [[0, 1, 2, 3], [1, 2, 3, 4]],
    "hexahedron": [[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]],
}
"""The cells as a mesh lists their corners."""


def by_hand(cell):
    cells = np.array(ORDERED[cell])
    if cell == "triangle":
        cells = cells[:, [0, 2, 1]]  # C order, though any would do
    return Mesh(cell, 1, np.array(CORNERS[cell]), cells, {"side": GMSH[cell][3]})


def by_gmsh(cell):
    family, cells, side, facets = GMSH[cell]
    corners = np.array(CORNERS[cell])
    dim = corners.shape[1]
    with gmsh_session():
        gmsh.model.add("pair")
        volume, surface = (gmsh.model.addDiscreteEntity(d) for d in (dim, dim - 1))
        positions = np.zeros((len(corners), 3))
        positions[:, :dim] = corners
        tags = 10 + 3 * np.arange(len(corners))  # gmsh's numbers may have gaps
        gmsh.model.mesh.addNodes(dim, volume, tags, positions.ravel())
        for entity, name, elements in ((volume, family, cells), (surface, side, facets)):
            kind = gmsh.model.mesh.getElementType(name, 1)
            nodes = tags[np.array(elements)].ravel()
            gmsh.model.mesh.addElementsByType(entity, kind, [], nodes)
        gmsh.model.mesh.reclassifyNodes()
        gmsh.model.addPhysicalGroup(dim, [volume])
        gmsh.model.addPhysicalGroup(dim - 1, [surface], name="side")
        return read_gmsh(gmsh.model)


def matrices(mesh, degree):
    """Stiffness, mass, spring on the side, each with rows in the order of the dofs' positions."""
    body = lagrange_body("pair", mesh, degree=degree, material=MATERIAL)
    sample = body.space.volume_cells()
    x = spsolve(csr_array(sample.values).tocsc(), sample.points)
    order = np.lexsort(np.round(x, 8).T)
    rows = (body.dim * order[:, None] + np.arange(body.dim)).ravel()
    side = body.surfaces["side"]
    points = side.gauss_points(4)
    N = side.trace(points.at)
    contact = (N.T @ csr_array(N * points.weight[:, None])).toarray()
    K, M = (csr(A).toarray()[np.ix_(rows, rows)] for A in (body.stiffness(), body.mass()))
    return x[order], K, M, contact[np.ix_(order, order)]


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("cell", ORDERED)
def test_two_cells_by_hand_have_the_matrices_of_those_of_gmsh(cell, degree):
    ours, gmshs = (matrices(make(cell), degree) for make in (by_hand, by_gmsh))
    assert ours[3].sum() > 0.4  # the area of the side
    for a, b in zip(ours, gmshs, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-13 * np.abs(b).max())


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


def test_points_of_no_cell_are_left_aside():
    mesh = by_hand("hexahedron")
    points = np.insert(mesh.points, 3, 77.0, axis=0)
    number = np.delete(np.arange(len(points)), 3)
    surfaces = {name: number[facets] for name, facets in mesh.surfaces.items()}
    more = Mesh(mesh.cell, 1, points, number[mesh.cells], surfaces)
    for a, b in zip(matrices(more, 2), matrices(mesh, 2), strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-13 * np.abs(b).max())


def test_no_mesh_and_inverted_cells_are_refused():
    with pytest.raises(InputError, match=r"^bodies\.part\.mesh = None"):
        lagrange_body("part", None, degree=1, material=MATERIAL)
    square = [[0, 0], [1, 0], [0, 1], [1, 1]]
    crossed = Mesh("quadrilateral", 1, square, [[0, 1, 3, 2]], {})
    with pytest.raises(InputError, match=r"^bodies\.part\.mesh = '1 of 1 cells'"):
        lagrange_body("part", crossed, degree=1, material=MATERIAL, comm=MPI.COMM_SELF)
