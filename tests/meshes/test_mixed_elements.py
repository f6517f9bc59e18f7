"""Bodies of hexahedra, wedges, pyramids and tetrahedra, divided into tetrahedra."""

from dataclasses import replace

import numpy as np
import pytest
from basix import CellType, LagrangeVariant, make_quadrature
from basix.ufl import element as lagrange
from mesh_writers import DECK, file_of, gmsh_wedges, mixed_blocks, mixed_file

from cea.errors import InputError
from cea.mesh import Mesh, facet_nodes, node_order
from meshes.files.content import block
from meshes.files.elements import KINDS
from meshes.files.part import check_elements
from meshes.files.tetrahedra import completed, tetrahedra
from meshes.mesh_file import MeshFile


def volumes(points, cells, order):
    """Volumes of tetrahedra, by a rule of degree 5."""
    at, weights = make_quadrature(CellType.tetrahedron, 5)
    shapes = lagrange("Lagrange", "tetrahedron", order, lagrange_variant=LagrangeVariant.equispaced)
    ours = np.argsort(node_order("tetrahedron", order, shapes._element.points))
    jacobians = np.einsum("dqn,cni->cqid", shapes.tabulate(1, at)[1:], points[cells[:, ours]])
    return np.einsum("q,cq->c", weights, np.linalg.det(jacobians))


def volume(mesh):
    """Volume of a mesh, each cell of which is right-handed."""
    found = volumes(mesh.points, mesh.cells, mesh.order)
    assert found.min() > 0
    return found.sum()


@pytest.mark.parametrize(
    ("name", "order", "element"),
    [
        *(("a.inp", 1, None), ("a.inp", 2, None), ("a.vtu", 1, None)),
        *(("a.cdb", 1, 185), ("a.cdb", 2, 186)),
    ],
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


@pytest.mark.parametrize("own", [True, False])
def test_an_edge_with_two_middles_is_refused(tmp_path, own):
    """Two quadratic tetrahedra over one face, one of whose edges may have two nodes."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1.0]])
    groups = [list(group) for group in KINDS["tetrahedron10"].groups]
    upper = [corners[group].mean(axis=0) for group in groups]
    lower = [corners[[(0, 2, 1, 4)[c] for c in group]].mean(axis=0) for group in groups]
    if own:
        lower[groups.index([1, 2])] += [0.01, 0.01, 0.0]
    points, rows = np.unique([*upper, *lower], axis=0, return_inverse=True)
    lines = ["*NODE", *(f"{i}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(points, 1))]
    lines += ["*ELEMENT, TYPE=C3D10"]
    for i, row in enumerate(rows.reshape(2, 10) + 1, 1):
        lines.append(", ".join(map(str, [i, *row])))
    file = tmp_path / "a.inp"
    file.write_text("\n".join(lines))
    if own:
        with pytest.raises(InputError, match=r"element 2.*match those of their neighbours"):
            MeshFile(str(file), "m").mesh([])
    else:
        assert volume(MeshFile(str(file), "m").mesh([])) == pytest.approx(1 / 3)


def bent(x):
    """A quadratic map, which elements of second order hold exactly."""
    x, y, z = x.T
    return np.stack([x + 0.02 * y * z, y + 0.015 * x * x, z + 0.02 * x * y - 0.01 * z * z], axis=1)


def bent_volume():
    """Volume that the map makes of the box, by Gauss points that are exact for it."""
    at, weights = np.polynomial.legendre.leggauss(3)
    x, y, z = np.meshgrid(*(length * (1 + at) / 2 for length in (3, 2, 3)), indexing="ij")
    one, none = np.ones_like(x), np.zeros_like(x)
    rows = [
        [one, 0.02 * z, 0.02 * y],
        [0.03 * x, one, none],
        [0.02 * y, 0.02 * x, one - 0.02 * z],
    ]
    determinants = np.linalg.det(np.moveaxis(np.array(rows), (0, 1), (-2, -1)))
    return 18 / 8 * np.einsum("i,j,k,ijk", weights, weights, weights, determinants)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("seed", range(5))
def test_tetrahedra_fill_the_body_and_match_across_faces(order, seed):
    points, blocks = mixed_blocks(order, seed, bent if order == 2 else lambda x: x)
    made, cells, elements, _ = tetrahedra(points, blocks)
    mesh = Mesh("tetrahedron", order, made, cells, {})
    assert volume(mesh) == pytest.approx(bent_volume() if order == 2 else 18.0, rel=1e-13)
    sides = np.concatenate([cells[:, f] for f in facet_nodes("tetrahedron", order)])
    _, times = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    assert times.max() == 2
    assert (times == 1).sum() == 2 * 2 * (3 * 2 + 3 * 2 + 3 * 3)  # two triangles on each square
    check_elements("tetrahedron", order, made, cells, elements)


def test_nodes_that_elements_have_are_kept_and_no_others_double():
    points, blocks = mixed_blocks(2, nodes=[27, 18, 14, 10], move=bent)
    whole, cells, *_ = tetrahedra(points, blocks)
    assert len(whole) == len(points)  # middles of faces and cells were all there
    added, others, *_ = tetrahedra(*mixed_blocks(2, move=bent))
    places = [p[np.unique(c)] for p, c in ((whole, cells), (added, others))]
    one, other = (each[np.lexsort(np.round(each, 9).T)] for each in places)
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-14)


def test_neighbours_of_20_and_27_nodes_share_the_middle_of_their_face():
    """Two hexahedra on a row: the one that lacks the middle of the face takes that of the other."""
    kind = KINDS["hexahedron27"]
    at = np.concatenate([kind.reference, kind.reference + np.array([1.0, 0.0, 0.0])])
    points, rows = np.unique(at, axis=0, return_inverse=True)
    first, second = rows.reshape(2, 1, 27)
    blocks = [
        block("whole", "hexahedron27", np.array([1]), first),
        block("fewer", "hexahedron20", np.array([2]), second[:, :20]),
    ]
    used = np.union1d(first, second[:, :20])
    renumbered = [replace(each, nodes=np.searchsorted(used, each.nodes)) for each in blocks]
    every, full = completed(points[used], renumbered)
    nodes = np.concatenate([each.nodes for each in full])
    assert (len(every), len(np.intersect1d(*nodes))) == (len(points), 9)
    np.testing.assert_allclose(every[nodes], at.reshape(2, 27, 3), atol=1e-15)
