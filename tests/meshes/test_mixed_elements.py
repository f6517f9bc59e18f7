"""Bodies of hexahedra, wedges, pyramids and tetrahedra from files of every format."""

import gmsh
import numpy as np
import pytest
from boxes_in_files import file_of
from mixed_blocks import mixed_blocks
from mixed_files import abaqus_deck, ansys_archive, vtu_file

from cea.errors import InputError
from meshes.files.kinds import FACES
from meshes.gmsh_model import gmsh_session
from meshes.mesh_file import MeshFile

WRITERS = {"a.inp": abaqus_deck, "a.cdb": ansys_archive, "a.vtu": vtu_file}


def volume(mesh):
    """Volume inside a mesh of tetrahedra with straight edges, whose middles are where they are."""
    corners = mesh.points[mesh.cells[:, {1: [0, 3, 2, 1], 2: [0, 9, 5, 2]}[mesh.order]]]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6


@pytest.mark.parametrize(
    ("name", "order"), [("a.inp", 1), ("a.inp", 2), ("a.cdb", 1), ("a.cdb", 2), ("a.vtu", 1)]
)
def test_a_body_of_all_solid_kinds_is_one_mesh_of_tetrahedra(tmp_path, name, order):
    file = file_of(tmp_path, name)
    points, blocks = mixed_blocks(order)
    low = np.flatnonzero(points[:, 1] == 0)
    WRITERS[name](file, points, blocks, low)
    body = MeshFile(str(file), "m", faces={"low": "LOW"})
    assert body.is_divided
    mesh = body.mesh(["low"])
    assert (mesh.cell, mesh.order) == ("tetrahedron", order)
    assert volume(mesh) == pytest.approx(18.0, rel=1e-12)
    on_low = mesh.points[mesh.surfaces["low"]]
    assert len(on_low) == 2 * 3 * 3
    assert (on_low[..., 1] == 0).all()


def test_cells_that_meshio_does_not_read_are_refused_by_their_name(tmp_path):
    file = file_of(tmp_path, "a.vtu")
    points, blocks = mixed_blocks(2)
    vtu_file(file, points, blocks, [0])
    with pytest.raises(InputError, match="cells of type wedge15"):
        MeshFile(str(file), "m")


def test_faces_of_elements_are_those_of_abaqus(tmp_path):
    points, blocks = mixed_blocks(1)
    file = tmp_path / "a.inp"
    abaqus_deck(file, points, blocks, [0])
    first = 1
    for block in blocks:
        for side in range(len(FACES[block.cell])):
            faces = {"side": f"{block.cell.upper()}:S{side + 1}"}
            try:
                found = MeshFile(str(file), "m", faces=faces).mesh(["side"])
            except InputError as error:
                assert "between two elements" in str(error)
                continue
            on = found.points[found.surfaces["side"]]
            assert np.any([(on[..., a] == end).all(axis=1).all() for a in range(3)
                           for end in (0, (3, 2, 3)[a])])  # fmt: skip
        first += len(block)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("version", [2.2, 4.1])
def test_wedges_and_pyramids_of_gmsh(tmp_path, order, version):
    file = tmp_path / "wedges.msh"
    with gmsh_session():
        base = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
        sides = gmsh.model.occ.extrude([(2, base)], 0, 0, 1, [2], recombine=True)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [sides[1][1]], name="body")
        gmsh.model.addPhysicalGroup(2, [base], name="below")
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(file))
    mesh = MeshFile(str(file), "m", part="body").mesh(["below"])
    assert (mesh.cell, mesh.order) == ("tetrahedron", order)
    assert volume(mesh) == pytest.approx(1.0, rel=1e-12)
    below = mesh.points[mesh.surfaces["below"]]
    assert (below[..., 2] == 0).all()
    corners = below[:, [0, -2, -1] if order == 1 else [0, 2, 5], :2]
    assert np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() == pytest.approx(2.0)
