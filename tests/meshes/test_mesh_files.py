"""Mesh files of every format: nodes, sets and faces as they were written, and what is refused."""

import gmsh
import numpy as np
import pytest
from mesh_writers import write

from cea.errors import InputError
from cea.mesh import Mesh, facet_nodes
from meshes.breaks import breaks_of
from meshes.gmsh_model import gmsh_session
from meshes.mesh_file import MeshFile
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Box, Rectangle

FILES = ("a.msh", "a22.msh", "binary.msh", "a.inp", "a.cdb", "a.bdf", "a.nas", "a.xdmf", "a.vtu")
NEEDED = {".cdb": "mapdl_archive", ".xdmf": "h5py", ".vtu": "meshio"}
KINDS = [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)]
TRUNCATED = {".bdf", ".nas"}
"""Formats whose numbers have twelve digits."""


def file_of(folder, name):
    """A file to write, where what reads its format is there."""
    file = folder / name
    if file.suffix in NEEDED:
        pytest.importorskip(NEEDED[file.suffix])
    return file


def bent(points):
    """A quadratic map: 20-node hexahedra hold it exactly, in any order of nodes but theirs not."""
    x, y, z = points.T
    return np.stack([x + 0.1 * y * z, 1 + y + 0.08 * x * x - 0.05 * z, z + 0.06 * x * y], axis=1)


def two_boxes(cell, order, elements=(2, 1, 3)):
    """Bent meshes of two boxes that do not touch."""
    shapes = {"left": Box((1.0, 0.5, 1.5)), "right": Box((1.0, 0.5, 1.5), (2.0, 0.25, 0.0))}
    meshes = {}
    for name, shape in shapes.items():
        flat = shape_mesh(shape, cell, order, breaks=breaks_of(shape, elements))
        meshes[name] = Mesh(cell, order, bent(flat.points), flat.cells, flat.surfaces)
    return meshes


def made(data, **changes):
    return MeshFile(**{**data, **changes})


def by_place(points):
    """Rows in the order of their coordinates."""
    return points[np.lexsort(np.round(points, 9).T)]


CASES = [(name, cell, order, True) for name in FILES for cell, order in KINDS]
CASES += [
    (name, "hexahedron", 2, False) for name in FILES if name.endswith((".msh", ".xdmf", ".vtu"))
]


@pytest.mark.parametrize(("name", "cell", "order", "lacking"), CASES)
def test_cells_and_faces_are_those_that_were_written(tmp_path, name, cell, order, lacking):
    file = file_of(tmp_path, name)
    meshes = two_boxes(cell, order)
    digits = 1e-11 if file.suffix in TRUNCATED else 1e-13
    for body, data in write(meshes, file, lacking).items():
        read, mesh = made(data), meshes[body]
        found = read.mesh(list(mesh.surfaces))
        assert (found.cell, found.order) == (cell, order)
        assert len(found.points) == len(mesh.points)
        assert read.fills_in == (lacking and (cell, order) == ("hexahedron", 2))
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


DECK = """*Heading
 two cubes of one part, the second shifted and turned
*PREPRINT, echo=NO
*Part, name=Cube
*Node
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.D0
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*Node, nset=Upper
9, 0., 0., 2.
10, 1., 0., 2.
11, 1., 1., 2.
12, 0., 1., 2.
** a comment, and an element over two lines
*Element, type=C3D8I,
  elset=First
1, 1, 2, 3, 4, 5,
6, 7, 8
*Element, type=C3D8R, elset=Second
7, 5, 6, 7, 8, 9, 10, 11, 12
*Nset, nset=Bottom, generate
1, 4
*Nset, nset=AllNodes
Bottom, UPPER, 5, 6, 7, 8
*Elset, elset=Both
 First, second
*Surface, type=ELEMENT, name=Top
Second, S2
*Surface, type=NODE, name=Base
Bottom,
*End Part
*Assembly, name=Assembly
*Instance, name=Cube-1, part=Cube
*End Instance
*Instance, name=Cube-2, part=CUBE
10., 0., 0.
10., 0., 0., 10., 0., 1., 90.
*End Instance
*Nset, nset=Held, instance=Cube-2
1, 2, 3, 4
*Elset, elset=_Side_S3, internal, instance=Cube-2
1, 7
*Surface, type=ELEMENT, name=Side
_Side_S3, S3
*End Assembly
*Step
*Node
1, 5., 5., 5.
*End Step
"""


def deck(folder, text=DECK):
    file = folder / "deck.inp"
    file.write_text(text)
    return file


@pytest.mark.parametrize("instance", ["Cube-1", "Cube-2"])
def test_parts_of_a_deck_are_put_where_their_instances_stand(tmp_path, instance):
    read = MeshFile(str(deck(tmp_path)), "m", part=instance)
    mesh = read.mesh(["Top", "Base"])
    turn = Placement(angle=90.0, translation=(10.0, 0.0, 0.0))
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1, 2)], dtype=float)
    expected = cube if instance == "Cube-1" else turn.apply(cube)
    np.testing.assert_allclose(by_place(mesh.points), by_place(expected), atol=1e-14)
    assert [set(mesh.points[mesh.surfaces[name]][0, :, 2]) for name in ("Top", "Base")] == [
        {2.0},
        {0.0},
    ]


@pytest.mark.parametrize(
    ("sets", "middles"),
    [
        ("Top", [[9.5, 0.5, 2.0]]),
        ("Side", [[10.0, 0.5, 0.5], [10.0, 0.5, 1.5]]),
        ("Held", [[9.5, 0.5, 0.0]]),
        ("Cube-2.Bottom", [[9.5, 0.5, 0.0]]),
        ("First:S1", [[9.5, 0.5, 0.0]]),
        ("Both:5", [[9.0, 0.5, 0.5], [9.0, 0.5, 1.5]]),
        (("Top", "Held"), [[9.5, 0.5, 0.0], [9.5, 0.5, 2.0]]),
        ("elements:Second", [[9, 0.5, 1.5], [9.5, 0, 1.5], [9.5, 0.5, 2], [9.5, 1, 1.5],
                             [10, 0.5, 1.5]]),
    ],
)  # fmt: skip
def test_faces_of_a_deck(tmp_path, sets, middles):
    read = MeshFile(str(deck(tmp_path)), "m", part="Cube-2", faces={"wanted": sets})
    mesh = read.mesh(["wanted"])
    found = mesh.points[mesh.surfaces["wanted"]].mean(axis=1)
    assert len(found) == len(middles)
    np.testing.assert_allclose(sorted(found.round(9).tolist()), sorted(middles), atol=1e-9)


def test_a_deck_may_be_in_several_files(tmp_path):
    head, _, rest = DECK.partition("*Element, type=C3D8R")
    (tmp_path / "part.txt").write_text("*Element, type=C3D8R" + rest)
    whole = MeshFile(str(deck(tmp_path)), "m", part="Cube-1").mesh(["Top"])
    split = deck(tmp_path, f"{head}*Include, input=part.txt\n")
    mesh = MeshFile(str(split), "m", part="Cube-1").mesh(["Top"])
    np.testing.assert_array_equal(mesh.points, whole.points)
    deck(tmp_path, "*INCLUDE, INPUT=deck.inp\n")
    with pytest.raises(InputError, match="include each other"):
        MeshFile(str(split), "m")


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


CUBE = """*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
*ELEMENT, TYPE=C3D8, ELSET=CUBE
1, 1, 2, 3, 4, 5, 6, 7, 8
*NSET, NSET=TOP
5, 6, 7, 8
"""
SHELL = "*ELEMENT, TYPE=S4, ELSET=SKIN\n2, 5, 6, 7, 8\n"
WEDGE = "*ELEMENT, TYPE=C3D6\n2, 1, 2, 3, 5, 6, 7\n"
TET = "*ELEMENT, TYPE=C3D4, ELSET=TET\n2, 1, 2, 3, 5\n"
AGAIN = "*NODE\n11,0,0,1\n12,1,0,1\n13,1,1,1\n14,0,1,1\n15,0,0,2\n16,1,0,2\n17,1,1,2\n18,0,1,2\n"
AGAIN += "*ELEMENT, TYPE=C3D8, ELSET=NEXT\n3, 11, 12, 13, 14, 15, 16, 17, 18\n"
FAR = AGAIN.replace(",1\n", ",5\n").replace(",2\n", ",6\n")


@pytest.mark.parametrize(
    ("text", "changes", "field", "words"),
    [
        (CUBE, {"unit": None}, "unit", "one of m, cm, mm"),
        (CUBE, {"part": "NONE"}, "part", "a set of elements: CUBE"),
        (CUBE, {"faces": {"wanted": "SIDE"}}, "faces", "one of the sets of the file: CUBE"),
        (CUBE, {"faces": {"wanted": "nodes:CUBE"}}, "faces", "one of the sets"),
        (CUBE + "*NSET, NSET=EDGE\n5, 6\n", {"faces": {"wanted": "EDGE"}}, "faces.wanted",
         "nowhere on the boundary"),
        (CUBE + AGAIN.replace("11, 12, 13, 14", "5, 6, 7, 8") + "*SURFACE, NAME=IN\n1, S2\n",
         {"faces": {"wanted": "IN"}}, "faces.wanted", "between two elements"),
        (CUBE + "*ELSET, ELSET=TOP\n1\n", {"faces": {"wanted": "TOP"}}, "faces.wanted",
         "elements:TOP or nodes:TOP"),
        (CUBE + SHELL, {}, "part", "solid elements alone, here are S4"),
        (CUBE + "*ELEMENT, TYPE=SPRINGA\n9, 1, 2\n", {}, "part", "here are SPRINGA"),
        (CUBE + WEDGE, {}, "part", "of one kind"),
        (CUBE + TET, {}, "part", "of one kind"),
        (SHELL, {}, "file", "a number of a node"),
        (CUBE.replace("C3D8", "S4R").replace(", 5, 6, 7, 8\n*NSET", "\n*NSET"), {}, "part", "S4R"),
        (CUBE + FAR, {}, "part", "these elements make 2"),
        (CUBE + AGAIN, {}, "part", "make 2 that share no nodes.* merge_nodes: 4 pairs"),
        (CUBE + AGAIN.replace("11, 12", "5, 6"), {}, "merge_nodes", "2 pairs of nodes lie in one"),
        (CUBE + AGAIN, {"merge_nodes": 0.6}, "merge_nodes", "less than half the shortest edge"),
        (CUBE.replace("2, 3, 4, 5", "2, 4, 3, 5"), {}, "file", "Jacobian is positive"),
        (CUBE.replace("1, 2, 3, 4, 5, 6, 7, 8\n*", "5, 6, 7, 8, 1, 2, 3, 4\n*"), {}, "file",
         "the first 1"),
        (CUBE.replace("3, 4, 5", "2, 4, 5"), {}, "file", "corners are apart"),
        (CUBE.replace("7, 8\n*NSET", "7\n*NSET"), {}, "file", "9 for each element"),
        (CUBE.replace("7, 8\n*NSET", "7, 9\n*NSET"), {}, "file", "a node that the file has"),
        (CUBE.replace("7, 1, 1, 1", "7, 1, x, 1"), {}, "file", "numbers in its data"),
        (CUBE.replace("7, 1, 1, 1", "7, 1, nan, 1"), {}, "file", "finite numbers"),
        (CUBE.replace("7, 1, 1, 1", "7, 1, 1"), {}, "file", "coordinates in each"),
        (CUBE + "*NGEN\n1, 8\n", {}, "file", "without this keyword"),
        (CUBE.replace("*NODE", "*NODE, SYSTEM=C"), {}, "file", "cartesian"),
        (CUBE + "*NSET, NSET=A\nB\n*NSET, NSET=B\nA\n", {}, "file", "inside each other"),
        (CUBE + "*NSET, NSET=A, GENERATE\n1, 999999999999999\n", {}, "file", "first, last"),
        (CUBE + "*SURFACE, NAME=A\n1, S7\n", {}, "file", "faces S1 to S6"),
        ("", {}, "file", "not empty"),
        ("nothing of the kind", {}, "file", r"\*NODE and \*ELEMENT"),
    ],
)  # fmt: skip
def test_what_is_refused(tmp_path, text, changes, field, words):
    file = tmp_path / "cube.inp"
    file.write_text(text)
    with pytest.raises(InputError, match=words) as refused:
        made({"file": str(file), "unit": "m"}, **changes).mesh(["wanted"] if "faces" in changes
                                                               else [])  # fmt: skip
    assert refused.value.field == field


def test_shells_may_be_named_as_marks_or_left_out_by_the_choice_of_a_part(tmp_path):
    (tmp_path / "cube.inp").write_text(CUBE + SHELL)
    data = {"file": str(tmp_path / "cube.inp"), "unit": "m"}
    named = made(data, faces={"skin": "SKIN"}).mesh(["skin"])
    chosen = made(data, part="CUBE").mesh(["TOP"])
    assert set(named.points[named.surfaces["skin"]][..., 2].ravel()) == {1.0}
    assert len(chosen.surfaces["TOP"]) == 1


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.msh", None, "a mesh file"),
        ("folder.msh", "folder", "a file"),
        ("a.step", b"ISO-10303-21;", "one that ends in .msh"),
        ("a.msh", b"*NODE\n1, 0, 0, 0\n", "a .msh file of gmsh"),
        ("a.bdf", b"GRID,1,,0.,0.,0.\n", "ENDDATA"),
        ("a.bdf", b"GRID,1,5,0.,0.,0.\nENDDATA\n", "basic coordinate system"),
        ("a.bdf", b"GRID           1       5     0.0     0.0     0.0\nENDDATA\n", "basic coord"),
        ("a.bdf", b"INCLUDE 'b.bdf'\nENDDATA\n", "one file"),
        ("a.xdmf", b"<Xdmf/>", "cannot be read"),
        ("a.vtu", b"\x00\xff" * 300, "cannot be read"),
        ("a.cdb", b"\x00\xff" * 300, "cannot be read"),
    ],
)
def test_files_that_are_none(tmp_path, name, content, words):
    file = file_of(tmp_path, name)
    if content == "folder":
        file.mkdir()
    elif content is not None:
        file.write_bytes(content)
    with pytest.raises(InputError, match=words) as refused:
        MeshFile(str(file), "m")
    assert refused.value.field == "file"


def test_nastran_elements_that_are_not_read_are_told(tmp_path):
    data = write(two_boxes("hexahedron", 1), tmp_path / "a.bdf")["left"]
    file = tmp_path / "a.bdf"
    text = file.read_text().replace("ENDDATA", "CELAS2,99,1.+3,1,1\nENDDATA")
    file.write_text(text)
    with pytest.raises(InputError, match="here are CELAS2, Quadrilateral 4 too"):
        made(data, part=None, faces={})
    assert made(data).num_cells == 6


def test_bricks_that_are_tetrahedra_are_read_as_such(tmp_path):
    pytest.importorskip("mapdl_archive")
    meshes = two_boxes("tetrahedron", 2)
    data = write(meshes, tmp_path / "a.cdb")["left"]
    text = (tmp_path / "a.cdb").read_text().splitlines()
    start = next(i for i, line in enumerate(text) if line.startswith("EBLOCK")) + 2
    end = text.index(f"{-1:9d}", start)
    lines = []
    for line in text[start:end]:
        numbers = [int(line[i : i + 9]) for i in range(0, len(line), 9)]
        if len(numbers) < 11:
            lines[-1] += numbers
        else:
            lines.append(numbers)
    bricks = []
    for numbers in lines:
        head, (i, j, k, m, ij, jk, ki, im, jm, km) = numbers[:11], numbers[11:]
        head[8] = 20
        nodes = [i, j, k, k, m, m, m, m, ij, jk, k, ki, m, m, m, m, im, jm, km, km]
        row = [*head, *nodes]
        bricks += ["".join(f"{n:9d}" for n in part) for part in (row[:19], row[19:])]
    text[start:end] = bricks
    changed = "\n".join(text).replace("ET, 1, 187", "ET, 1, 186")
    (tmp_path / "b.cdb").write_text(changed)
    ours, theirs = (made(data, file=str(tmp_path / name)).mesh(["x_min"]) for name in
                    ("a.cdb", "b.cdb"))  # fmt: skip
    np.testing.assert_array_equal(ours.points[ours.cells], theirs.points[theirs.cells])


def test_plane_kinds_have_their_nodes(tmp_path):
    pytest.importorskip("meshio")
    import meshio

    shape = Rectangle((2.0, 1.0))
    flat = shape_mesh(shape, "quadrilateral", 2, breaks=breaks_of(shape, (2, 2)))
    from mesh_writers import listed

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
