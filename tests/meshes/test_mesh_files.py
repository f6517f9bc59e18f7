"""Mesh files of every format: nodes, cells, sets and faces as they were written."""

import meshio
import numpy as np
import pytest
from covering import covering
from dolfinx import io
from dolfinx import mesh as dolfinx_mesh
from gmsh_models import volumes
from mesh_writers import by_place, file_of, gmsh_boxes, listed, made, two_boxes, write
from mpi4py import MPI

from cea.errors import InputError
from meshes.breaks import breaks_of
from meshes.mesh_file import MeshFile
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Rectangle

pytestmark = pytest.mark.usefixtures("files_read_here")
FILES = ("a.msh", "a22.msh", "binary.msh", "a.inp", "a.cdb", "a.bdf", "a.nas", "a.xdmf", "a.vtu")
KINDS = [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)]
TETRAHEDRA = {285: 1, 185: 1, 187: 2, 186: 2}
"""Orders of types of elements in archives of Ansys: SOLID185 and 186 are bricks."""


@pytest.mark.parametrize(
    ("name", "kind", "lacking", "element"),
    [
        *(pytest.param(*each.values, True, None, marks=each.marks) for each in
          covering(FILES, KINDS, strength=1)),
        *((name, ("hexahedron", 2), False, None) for name in FILES
          if name.endswith((".msh", ".xdmf", ".vtu"))),
        *(("a.cdb", ("tetrahedron", n), True, element) for element, n in TETRAHEDRA.items()),
    ],
)  # fmt: skip
def test_cells_and_faces_are_those_that_were_written(tmp_path, name, kind, lacking, element):
    file, meshes = file_of(tmp_path, name), two_boxes(*kind)
    digits = 1e-11 if file.suffix in (".bdf", ".nas") else 1e-13  # of twelve digits
    for body, data in write(meshes, file, lacking, element).items():
        read, mesh = made(data), meshes[body]
        found = read.mesh(list(mesh.surfaces))
        assert (found.cell, found.order, len(found.points)) == (*kind, len(mesh.points))
        assert read.elements.incomplete == (lacking and kind == ("hexahedron", 2))
        ours, theirs = found.points[found.cells], mesh.points[mesh.cells]
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=digits)
        for surface, facets in mesh.surfaces.items():
            ours = by_place(found.points[found.surfaces[surface]].mean(axis=1))
            theirs = by_place(mesh.points[facets].mean(axis=1))
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=10 * digits)


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("in", 0.0254), ("ft", 0.3048)])
def test_units_and_places(tmp_path, unit, metres):
    meshes = two_boxes("hexahedron", 1)
    read = made(write(meshes, tmp_path / "a.inp")["right"], unit=unit)
    place, points = Placement(angle=90.0, translation=(1.0, 2.0, 3.0)), meshes["right"].points
    found, expected = read.mesh(["x_min"], place).points, place.apply(metres * points)
    np.testing.assert_allclose(by_place(found), by_place(expected), atol=1e-15)
    ends = metres * np.array([points.min(axis=0), points.max(axis=0)])
    np.testing.assert_allclose(np.array(read.extent).T, ends, atol=1e-15)


@pytest.mark.parametrize("order", [3, 4])
def test_gmsh_files_of_high_order(tmp_path, order):
    mesh = MeshFile(gmsh_boxes(tmp_path / "a.msh", order=order), "m").mesh(["face 0.0", "face 1.0"])
    assert mesh.order == order
    for x in (0.0, 1.0):
        facets = mesh.surfaces[f"face {x}"]
        assert set(mesh.points[facets][..., 0].ravel()) == {x}
        assert facets.shape[1] == (order + 1) * (order + 2) / 2


def test_two_bodies_are_told_apart_or_made_one(tmp_path):
    file = gmsh_boxes(tmp_path / "a.msh", 2)
    with pytest.raises(InputError, match=r"part = None.*box 0.5, box 1.5.* merge_nodes"):
        MeshFile(file, "m").mesh([])
    one = MeshFile(file, "m", merge_nodes=1e-6)
    halves = [MeshFile(file, "m", part=f"box {x}") for x in (0.5, 1.5)]
    shared = 4 + 1  # corners of the faces that touch, and their middle
    assert len(one.mesh([]).points) == sum(len(half.mesh([]).points) for half in halves) - shared
    assert one.extent == ((0.0, 2.0), (0.0, 1.0), (0.0, 1.0))
    assert halves[1].extent[0] == (1.0, 2.0)


@pytest.mark.parametrize("version", [2.2, 4.0, 4.1])
def test_a_volume_in_two_groups_is_there_once(tmp_path, version):
    """Files of version 2.2 list elements once for each group."""
    file = gmsh_boxes(tmp_path / "a.msh", 2, shared=True, version=version)
    every, whole, half = (MeshFile(file, "m", part=part) for part in (None, "whole", "box 1.5"))
    assert (whole.extent[0], half.extent[0]) == ((0.0, 2.0), (1.0, 2.0))
    count = whole.elements.num_cells
    assert (every.elements.num_cells, 2 * half.elements.num_cells) == (count, count)
    mesh = whole.mesh(["face 0.0"])
    assert (mesh.points[mesh.surfaces["face 0.0"]][..., 0] == 0).all()


def test_plane_strain_bodies_may_be_seen_from_behind(tmp_path):
    """Listed clockwise."""
    file, nodes = tmp_path / "a.inp", "1, 0, 0\n2, 0, 1\n3, 2, 1\n4, 2, 0\n"
    cells = "*ELEMENT, TYPE=CPE3\n1, 1, 2, 3\n2, 1, 3, 4\n"
    file.write_text(f"*NODE\n{nodes}{cells}*NSET, NSET=TOP\n2, 3\n")
    read = MeshFile(str(file), "cm")
    mesh = read.mesh(["TOP"])
    assert (read.directions, mesh.cell, mesh.dim) == (("x", "y"), "triangle", 2)
    np.testing.assert_array_equal(mesh.points[mesh.surfaces["TOP"]][..., 1], 0.01)


@pytest.mark.parametrize("lacking", [True, False])
def test_plane_kinds_have_their_nodes(tmp_path, lacking):
    shape, file = Rectangle((2.0, 1.0)), file_of(tmp_path, "a.vtu")
    flat = shape_mesh(shape, "quadrilateral", 2, breaks=breaks_of(shape, (2, 2)))
    _, order = listed("quadrilateral", 2, lacking)
    used, nodes = np.unique(flat.cells[:, order], return_inverse=True)
    points = np.column_stack([flat.points[used], np.zeros(len(used))])
    meshio.write(file, meshio.Mesh(points, [(f"quad{len(order)}", nodes.reshape(4, -1))]))
    mesh = MeshFile(str(file), "m").mesh([])
    expected = flat.points[flat.cells]
    np.testing.assert_allclose(mesh.points[mesh.cells], expected, rtol=0, atol=1e-15)


def test_nodes_in_several_blocks_of_ansys(tmp_path):
    file = file_of(tmp_path, "a.cdb")
    data = write(two_boxes("hexahedron", 2), file, lacking=True)["right"]
    whole = made(data).mesh(["x_min"])
    lines = file.read_text().splitlines()
    start, end = (next(i for i, line in enumerate(lines) if line.startswith(word)) for word in
                  ("NBLOCK", "N,R5.3"))  # fmt: skip
    nodes, n = lines[start + 2 : end], end - start - 2
    blocks = []
    for part in (nodes[: n // 3], nodes[n // 3 :]):
        blocks += [f"NBLOCK,6,SOLID,{n},{len(part)}", lines[start + 1], *part, lines[end]]
    file.write_text("\n".join([*lines[:start], *blocks, *lines[end + 1 :]]) + "\n")
    read = made(data).mesh(["x_min"])
    np.testing.assert_array_equal(read.points[read.cells], whole.points[whole.cells])
    np.testing.assert_array_equal(read.surfaces["x_min"], whole.surfaces["x_min"])


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_a_mesh_and_its_tags_as_dolfinx_writes_them(tmp_path, cell):
    file = file_of(tmp_path, "a.xdmf")
    ends, kind = np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 1.0]]), dolfinx_mesh.CellType[cell]
    box = dolfinx_mesh.create_box(MPI.COMM_SELF, ends, [4, 2, 2], kind)
    n = box.topology.index_map(3).size_local
    middles = dolfinx_mesh.compute_midpoints(box, 3, np.arange(n, dtype=np.int32))
    box.topology.create_connectivity(2, 3)
    low = dolfinx_mesh.locate_entities_boundary(box, 2, lambda x: np.isclose(x[0], 0))
    with io.XDMFFile(MPI.COMM_SELF, str(file), "w") as written:
        written.write_mesh(box)
        for name, dim, entities, values in (
            ("cells", 3, np.arange(n), 1 + (middles[:, 0] > 1)),
            ("facets", 2, np.sort(low), np.full(len(low), 7)),
        ):
            given = entities.astype(np.int32), values.astype(np.int32)
            tags = dolfinx_mesh.meshtags(box, dim, *given)
            tags.name = name
            written.write_meshtags(tags, box.geometry)
    whole, half = (MeshFile(str(file), "m", part=part) for part in (None, "cells 1"))
    assert whole.elements.num_cells == 2 * half.elements.num_cells == n
    assert half.extent == ((0.0, 1.0), (0.0, 1.0), (0.0, 1.0))
    half = MeshFile(str(file), "m", part="cells 1", faces={"low": "facets 7"})
    mesh = half.mesh(["low"])
    on = mesh.points[mesh.surfaces["low"]]
    assert (on[..., 0] == 0).all()
    assert len(on) == len(low)


def test_several_kinds_of_cells_in_one_topology(tmp_path):
    """A cube of two wedges beside a hexahedron."""
    points = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1, 2)]
    wedges = [[1, 2, 5, 7, 8, 11], [1, 5, 4, 7, 11, 10]]
    cells = [("hexahedron", [[0, 1, 4, 3, 6, 7, 10, 9]]), ("wedge", wedges)]
    meshio.write(tmp_path / "a.xdmf", meshio.Mesh(points, cells), data_format="XML")
    body = MeshFile(str(tmp_path / "a.xdmf"), "m")
    assert volumes(body.mesh([])).sum() == pytest.approx(2.0)
    assert "wedge" in [block.cell for block in body.content.blocks]
