"""Bodies of hexahedra, wedges, pyramids and tetrahedra, divided into tetrahedra."""

import numpy as np
import pytest
from basix import CellType, LagrangeVariant, make_quadrature
from basix.ufl import element as lagrange
from mesh_writers import DECK, file_of, gmsh_wedges, mixed_blocks, mixed_file

from cea.errors import InputError
from cea.mesh import Mesh, facet_nodes, node_order
from meshes.files.elements import KINDS
from meshes.files.part import check_elements
from meshes.files.tetrahedra import tetrahedra
from meshes.mesh_file import MeshFile


def volume(mesh):
    """Volume of tetrahedra by a rule of degree 5; each is right-handed."""
    at, weights = make_quadrature(CellType.tetrahedron, 5)
    name, variant = "tetrahedron", LagrangeVariant.equispaced
    shapes = lagrange("Lagrange", name, mesh.order, lagrange_variant=variant)
    ours = np.argsort(node_order(name, mesh.order, shapes._element.points))
    nodes = mesh.points[mesh.cells[:, ours]]
    jacobians = np.einsum("dqn,cni->cqid", shapes.tabulate(1, at)[1:], nodes)
    found = np.linalg.det(jacobians) @ weights
    assert found.min() > 0
    return found.sum()


@pytest.mark.parametrize(
    ("name", "order", "element"),
    [("a.inp", 1, None), ("a.inp", 2, None), ("a.cdb", 1, 185), ("a.cdb", 2, 186)],
)
def test_a_body_of_all_solid_kinds_is_one_mesh_of_tetrahedra(tmp_path, name, order, element):
    """With a type of elements an archive has bricks whose nodes fall on one another."""
    file = file_of(tmp_path, name)
    mixed_file(file, order, element)
    body = MeshFile(str(file), "m", faces={"low": "LOW"})
    mesh = body.mesh(["low"])
    assert (body.elements.is_divided, mesh.cell, mesh.order) == (True, "tetrahedron", order)
    assert volume(mesh) == pytest.approx(18.0, rel=1e-12)
    on_low = mesh.points[mesh.surfaces["low"]]
    assert len(on_low) == 2 * 3 * 3
    assert (on_low[..., 1] == 0).all()


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
    for one in blocks:
        for nodes in one.nodes:
            element += 1
            for side, face in enumerate(ABAQUS_FACES[one.cell], 1):
                on = points[[nodes[int(corner) - 1] for corner in face]]
                lines += [f"{element}, S{side}"] if (on[:, 1] == 2).all() else []
    file.write_text(file.read_text() + "\n".join(lines) + "\n")
    mesh = MeshFile(str(file), "m").mesh(["HIGH"])
    on = mesh.points[mesh.surfaces["HIGH"]]
    assert (on[..., 1] == 2).all()
    assert len(on) == 2 * 3 * 3


@pytest.mark.grid
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("version", [2.2, 4.1])
def test_wedges_and_pyramids_of_gmsh(tmp_path, order, version):
    file = gmsh_wedges(tmp_path / "wedges.msh", order=order, version=version)
    mesh = MeshFile(file, "m", part="body").mesh(["below"])
    assert (mesh.cell, mesh.order) == ("tetrahedron", order)
    assert volume(mesh) == pytest.approx(1.0, rel=1e-12)
    below = mesh.points[mesh.surfaces["below"]]
    assert (below[..., 2] == 0).all()
    corners = below[:, [0, -2, -1] if order == 1 else [0, 2, 5], :2]
    assert np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() == pytest.approx(2.0)


NODES = DECK[DECK.index("*Node") : DECK.index("** a comment")]
"""Corners of two cubes on each other."""
ONE_WAY, OTHER_WAY = ((1, 2, 3), (1, 3, 4)), ((1, 2, 4), (2, 3, 4))


@pytest.mark.parametrize(("upper", "fits"), [(ONE_WAY, True), (OTHER_WAY, False)])
def test_faces_that_are_cut_along_two_diagonals_are_refused(tmp_path, upper, fits):
    lines = ["*ELEMENT, TYPE=C3D6"]
    for z, triangles in enumerate((ONE_WAY, upper)):
        for nodes in triangles:
            numbers = [len(lines), *(4 * (z + top) + n for top in (0, 1) for n in nodes)]
            lines.append(", ".join(map(str, numbers)))
    file = tmp_path / "a.inp"
    file.write_text(NODES + "\n".join(lines))
    if fits:
        assert volume(MeshFile(str(file), "m").mesh([])) == pytest.approx(2.0)
    else:
        with pytest.raises(InputError, match="match those of their neighbours"):
            MeshFile(str(file), "m").mesh([])


def test_an_edge_with_two_middles_is_refused(tmp_path):
    """Two quadratic tetrahedra over one face, one of whose edges has two nodes."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1.0]])
    groups = [list(group) for group in KINDS["tetrahedron10"].groups]
    upper = [corners[group].mean(axis=0) for group in groups]
    lower = [corners[[(0, 2, 1, 4)[c] for c in group]].mean(axis=0) for group in groups]
    lower[groups.index([1, 2])] += [0.01, 0.01, 0.0]
    points, rows = np.unique([*upper, *lower], axis=0, return_inverse=True)
    lines = ["*NODE", *(f"{i}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(points, 1))]
    lines += ["*ELEMENT, TYPE=C3D10"]
    for i, row in enumerate(rows.reshape(2, 10) + 1, 1):
        lines.append(", ".join(map(str, [i, *row])))
    file = tmp_path / "a.inp"
    file.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"element 2.*match those of their neighbours"):
        MeshFile(str(file), "m").mesh([])


def bent(x):
    """A quadratic map, which elements of second order hold exactly."""
    x, y, z = x.T
    return np.stack([x + 0.02 * y * z, y + 0.015 * x * x, z + 0.02 * x * y - 0.01 * z * z], axis=1)


BENT_VOLUME = 17.42772
"""Integral of the determinant of the map over the box of 3 x 2 x 3."""


@pytest.mark.parametrize(
    "nodes", [(8, 6, 5, 4), (20, 15, 13, 10), (27, 15, 13, 10), (27, 18, 14, 10)]
)
@pytest.mark.parametrize("seed", range(3))
def test_tetrahedra_fill_the_body_and_match_across_faces(nodes, seed):
    """Where elements lack the middle of a face that their neighbour has, they take that one."""
    order = 1 if nodes[0] == 8 else 2
    points, blocks = mixed_blocks(nodes, seed, bent if order == 2 else lambda x: x)
    made, cells, elements, _ = tetrahedra(points, blocks)
    mesh = Mesh("tetrahedron", order, made, cells, {})
    assert volume(mesh) == pytest.approx(BENT_VOLUME if order == 2 else 18.0, rel=1e-13)
    sides = np.concatenate([cells[:, f] for f in facet_nodes("tetrahedron", order)])
    _, times = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    assert times.max() == 2
    assert (times == 1).sum() == 2 * 2 * (3 * 2 + 3 * 2 + 3 * 3)  # two triangles on each square
    check_elements("tetrahedron", order, made, cells, elements)
    assert nodes[1] != 18 or len(made) == len(points)  # middles of faces and cells were all there
