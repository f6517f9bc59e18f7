"""Mesh files of every format: nodes, cells, sets and faces as they were written."""

import gmsh
import numpy as np
import pytest
from covering import covering
from mesh_writers import by_place, file_of, listed, made, two_boxes, write

from cea.errors import InputError
from cea.mesh import facet_nodes
from meshes.breaks import breaks_of
from meshes.mesh_file import MeshFile
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Rectangle
from meshes.unstructured import gmsh_session

FILES = ("a.msh", "a22.msh", "binary.msh", "a.inp", "a.cdb", "a.bdf", "a.nas", "a.xdmf", "a.vtu")
KINDS = [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)]
TRUNCATED = {".bdf", ".nas"}
"""Formats whose numbers have twelve digits."""


WITH_ALL_NODES = [name for name in FILES if name.endswith((".msh", ".xdmf", ".vtu"))]
"""Files that may hold hexahedra of second order with all their nodes."""


@pytest.mark.parametrize(("name", "kind"), covering(FILES, KINDS, strength=1))
def test_cells_and_faces_are_those_that_were_written(tmp_path, name, kind):
    check_what_was_written(tmp_path, name, *kind, lacking=True)


@pytest.mark.parametrize("name", WITH_ALL_NODES)
def test_hexahedra_with_all_nodes_are_those_that_were_written(tmp_path, name):
    check_what_was_written(tmp_path, name, "hexahedron", 2, lacking=False)


def check_what_was_written(tmp_path, name, cell, order, *, lacking):
    file = file_of(tmp_path, name)
    meshes = two_boxes(cell, order)
    digits = 1e-11 if file.suffix in TRUNCATED else 1e-13
    for body, data in write(meshes, file, lacking).items():
        read, mesh = made(data), meshes[body]
        found = read.mesh(list(mesh.surfaces))
        assert (found.cell, found.order) == (cell, order)
        assert len(found.points) == len(mesh.points)
        assert read.elements.incomplete == (lacking and (cell, order) == ("hexahedron", 2))
        ours, theirs = found.points[found.cells], mesh.points[mesh.cells]
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=digits)
        for surface, facets in mesh.surfaces.items():
            middles = [m.points[f].mean(axis=1) for m, f in
                       ((found, found.surfaces[surface]), (mesh, facets))]  # fmt: skip
            np.testing.assert_allclose(*map(by_place, middles), rtol=0, atol=10 * digits)


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("in", 0.0254), ("ft", 0.3048)])
def test_units_and_places(tmp_path, unit, metres):
    meshes = two_boxes("hexahedron", 1)
    data = write(meshes, tmp_path / "a.inp")["right"]
    place = Placement(angle=90.0, translation=(1.0, 2.0, 3.0))
    read = made(data, unit=unit)
    found = read.mesh(["x_min"], place)
    expected = place.apply(metres * meshes["right"].points)
    np.testing.assert_allclose(by_place(found.points), by_place(expected), atol=1e-15)
    low, high = np.array(read.extent).T
    np.testing.assert_allclose(low, metres * meshes["right"].points.min(axis=0), atol=1e-15)
    np.testing.assert_allclose(high, metres * meshes["right"].points.max(axis=0), atol=1e-15)


def gmsh_file(file, *, second=False, groups=True, order=1):
    """Tetrahedra of one box, or of two that touch and do not share nodes."""
    with gmsh_session():
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        if second:
            gmsh.model.occ.addBox(1, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        if groups:
            for _, tag in gmsh.model.getEntities(3):
                gmsh.model.addPhysicalGroup(3, [tag], name=f"box {tag}")
            for _, tag in gmsh.model.getEntities(2):
                gmsh.model.addPhysicalGroup(2, [tag], name=f"face {tag}")
        gmsh.option.setNumber("Mesh.MeshSizeMin", 1.0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 1.0)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(file))
    return str(file)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_gmsh_files_of_every_order(tmp_path, order):
    file = gmsh_file(tmp_path / "a.msh", order=order)
    mesh = MeshFile(file, "m").mesh(["face 1", "face 2"])
    assert mesh.order == order
    assert set(mesh.points[mesh.surfaces["face 2"]][..., 0].ravel()) == {1.0}
    sides = [len(nodes) for nodes in facet_nodes(mesh.cell, order)]
    assert mesh.surfaces["face 1"].shape[1] == sides[0]


def test_two_bodies_are_told_apart_or_made_one(tmp_path):
    file = gmsh_file(tmp_path / "a.msh", second=True)
    with pytest.raises(InputError, match=r"part = None.*box 1, box 2.* merge_nodes"):
        MeshFile(file, "m").mesh([])
    one = MeshFile(file, "m", merge_nodes=1e-6)
    halves = [MeshFile(file, "m", part=f"box {k}") for k in (1, 2)]
    meshes = [body.mesh([]) for body in halves]
    shared = 4 + 1  # corners of the faces that touch, and their middle
    assert len(one.mesh([]).points) == sum(len(m.points) for m in meshes) - shared
    assert one.extent == ((0.0, 2.0), (0.0, 1.0), (0.0, 1.0))
    assert halves[1].extent[0] == (1.0, 2.0)


def test_plane_strain_bodies_may_be_seen_from_behind(tmp_path):
    with gmsh_session():
        corners = [(0, 0), (0, 1), (2, 1), (2, 0)]
        points = [gmsh.model.geo.addPoint(x, y, 0, 0.5) for x, y in corners]
        lines = [gmsh.model.geo.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
        face = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
        gmsh.model.geo.synchronize()
        gmsh.model.addPhysicalGroup(1, [lines[1]], name="top")
        gmsh.model.addPhysicalGroup(2, [face], name="plate")
        gmsh.model.mesh.generate(2)
        gmsh.write(str(tmp_path / "a.msh"))
    read = MeshFile(str(tmp_path / "a.msh"), "cm")
    assert read.directions == ("x", "y")
    mesh = read.mesh(["top"])
    assert (mesh.cell, mesh.dim) == ("triangle", 2)
    np.testing.assert_array_equal(mesh.points[mesh.surfaces["top"]][..., 1], 0.01)


def test_plane_kinds_have_their_nodes(tmp_path):
    pytest.importorskip("meshio")
    import meshio

    shape = Rectangle((2.0, 1.0))
    flat = shape_mesh(shape, "quadrilateral", 2, breaks=breaks_of(shape, (2, 2)))
    for lacking in (True, False):
        kind, order = listed("quadrilateral", 2, lacking)
        nodes = flat.cells[:, order]
        used = np.unique(nodes)
        number = np.full(len(flat.points), -1)
        number[used] = np.arange(len(used))
        file = tmp_path / f"{kind}.vtu"
        points = np.column_stack([flat.points[used], np.zeros(len(used))])
        meshio.write(file, meshio.Mesh(points, [(f"quad{len(order)}", number[nodes])]))
        mesh = MeshFile(str(file), "m").mesh([])
        np.testing.assert_allclose(
            mesh.points[mesh.cells], flat.points[flat.cells], rtol=0, atol=1e-15
        )
