"""Bodies of hexahedra, wedges, pyramids and tetrahedra from files of every format."""

import gmsh
import numpy as np
import pytest
from mesh_writers import file_of, mixed_file

from cea.errors import InputError
from meshes.files.elements import KINDS
from meshes.mesh_file import MeshFile
from meshes.unstructured import gmsh_session


def volume(mesh):
    """Volume inside a mesh of tetrahedra with straight edges, whose middles are where they are."""
    corners = mesh.points[mesh.cells[:, {1: [0, 3, 2, 1], 2: [0, 9, 5, 2]}[mesh.order]]]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6


@pytest.mark.parametrize(
    ("name", "order"), [("a.inp", 1), ("a.inp", 2), ("a.cdb", 1), ("a.cdb", 2), ("a.vtu", 1)]
)
def test_a_body_of_all_solid_kinds_is_one_mesh_of_tetrahedra(tmp_path, name, order):
    file = file_of(tmp_path, name)
    mixed_file(file, order)
    body = MeshFile(str(file), "m", faces={"low": "LOW"})
    assert body.elements.is_divided
    mesh = body.mesh(["low"])
    assert (mesh.cell, mesh.order) == ("tetrahedron", order)
    assert volume(mesh) == pytest.approx(18.0, rel=1e-12)
    on_low = mesh.points[mesh.surfaces["low"]]
    assert len(on_low) == 2 * 3 * 3
    assert (on_low[..., 1] == 0).all()


def test_cells_that_meshio_does_not_read_are_refused_by_their_name(tmp_path):
    file = file_of(tmp_path, "a.vtu")
    mixed_file(file, 2)
    with pytest.raises(InputError, match="cells of type wedge15"):
        MeshFile(str(file), "m")


ABAQUS_FACES = {
    "hexahedron": ["1234", "5876", "1562", "2673", "3784", "4851"],
    "wedge": ["123", "465", "1452", "2563", "3641"],
    "pyramid": ["1234", "152", "253", "354", "451"],
    "tetrahedron": ["123", "142", "243", "341"],
}
"""Nodes of S1, S2, ... in the manual of Abaqus."""


def test_faces_of_elements_are_those_of_the_manual(tmp_path):
    """The faces on the side y = 2, each named by its element and number, are that side."""
    file = tmp_path / "a.inp"
    points, blocks = mixed_file(file, 1)
    lines, element = ["*SURFACE, NAME=HIGH"], 0
    for block in blocks:
        for nodes in block.nodes:
            element += 1
            for side, face in enumerate(ABAQUS_FACES[block.cell], 1):
                on = points[[nodes[int(corner) - 1] for corner in face]]
                lines += [f"{element}, S{side}"] if (on[:, 1] == 2).all() else []
    file.write_text(file.read_text() + "\n".join(lines) + "\n")
    mesh = MeshFile(str(file), "m").mesh(["HIGH"])
    on = mesh.points[mesh.surfaces["HIGH"]]
    assert (on[..., 1] == 2).all()
    assert len(on) == 2 * 3 * 3


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


LAYERS = "*NODE\n" + "".join(
    f"{4 * z + n}, {x}, {y}, {z}\n"
    for z in range(3)
    for n, (x, y) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)], 1)
)
ONE_WAY, OTHER_WAY = ((1, 2, 3), (1, 3, 4)), ((1, 2, 4), (2, 3, 4))


@pytest.mark.parametrize(("upper", "fits"), [(ONE_WAY, True), (OTHER_WAY, False)])
def test_faces_that_are_cut_along_two_diagonals_are_refused(tmp_path, upper, fits):
    lines = ["*ELEMENT, TYPE=C3D6"]
    for z, triangles in enumerate((ONE_WAY, upper)):
        for nodes in triangles:
            numbers = [len(lines), *(4 * (z + top) + n for top in (0, 1) for n in nodes)]
            lines.append(", ".join(map(str, numbers)))
    file = tmp_path / "a.inp"
    file.write_text(LAYERS + "\n".join(lines))
    if fits:
        assert volume(MeshFile(str(file), "m").mesh([])) == pytest.approx(2.0)
    else:
        with pytest.raises(InputError, match="match those of their neighbours"):
            MeshFile(str(file), "m").mesh([])


@pytest.mark.parametrize("own", [True, False])
def test_an_edge_with_two_middles_is_refused(tmp_path, own):
    """Two quadratic tetrahedra over one face, one of whose edges may have two nodes."""
    kind = KINDS["tetrahedron10"]
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1.0]])
    upper = [corners[list(group)].mean(axis=0) for group in kind.groups]
    groups = [[(0, 2, 1, 4)[c] for c in group] for group in kind.groups]
    points, rows = list(upper), []
    for group in groups:
        at = corners[group].mean(axis=0)
        same = [i for i, x in enumerate(points) if np.allclose(x, at)]
        if own and sorted(group) == [1, 2]:
            same, at = [], at + np.array([0.01, 0.01, 0.0])
        if not same:
            points.append(at)
        rows.append(same[0] if same else len(points) - 1)
    nodes = "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(points, 1))
    elements = "".join(
        f"{i}, " + ", ".join(str(n + 1) for n in row) + "\n"
        for i, row in enumerate((range(10), rows), 1)
    )
    file = tmp_path / "a.inp"
    file.write_text(f"*NODE\n{nodes}*ELEMENT, TYPE=C3D10\n{elements}")
    if own:
        with pytest.raises(InputError, match=r"element 2.*match those of their neighbours"):
            MeshFile(str(file), "m").mesh([])
    else:
        assert volume(MeshFile(str(file), "m").mesh([])) == pytest.approx(1 / 3)
