"""Nastran files: spellings of cards, points in coordinate systems, elements, sets, refusals."""

import numpy as np
import pytest

from cea.errors import InputError
from meshes.files.elements import CORNERS, KINDS
from meshes.files.reading import read_mesh_file
from meshes.mesh_file import MeshFile

CUBE = CORNERS["hexahedron"]
X = CUBE * [0.02, 0.015, 0.01] - [0.0, 0.015, 0.0]
CARDS = [["GRID", i, "", *x] for i, x in enumerate(X.tolist(), 1)]
CARDS += [["CHEXA", 1, 7, *range(1, 9)]]


def number(value):
    return f"{value:.4f}" if isinstance(value, float) else str(value)


def small(cards, first="+", end=""):
    lines = []
    for name, *fields in cards:
        for i in range(0, len(fields), 8):
            head = name if i == 0 else first
            row = "".join(f"{number(field):>8}" for field in fields[i : i + 8])
            lines.append(f"{head:<8}{row}{end}")
    return "\n".join(lines) + "\n"


def free(cards, first="+", between=","):
    lines = []
    for name, *fields in cards:
        for i in range(0, len(fields), 8):
            part = [name if i == 0 else first, *map(number, fields[i : i + 8])]
            lines.append(between.join(part))
    return "\n".join(lines) + "\n"


SPELLINGS = {
    "fixed fields": small(CARDS),
    "named marks": small(CARDS, "+E1").replace("       6\n", "       6+E1\n"),
    "numbers in columns 73 to 80": small(CARDS[:-1], end=" " * 24 + "    1000") + small(CARDS[-1:]),
    "exponents without E": small(CARDS).replace("0.0200", "  2.-2"),
    "exponents with D": small(CARDS).replace("0.0200", "2.0D-2"),
    "zeros left out": small([[x if x != 0 else "" for x in card] for card in CARDS]),
    "comments behind fields": small(CARDS, end="  $ last") + "$ GRID, 1, 5\n",
    "large fields": "".join(f"GRID*   {i:16}{'':16}{x:16.4f}{y:16.4f}\n*       {z:16.4f}\n" for
                            i, (x, y, z) in enumerate(X.tolist(), 1)) + small(CARDS[-1:]),
    "free fields": free(CARDS),
    "free fields, blank first": free(CARDS, ""),
    "free fields with blanks": free(CARDS, between="  , "),
    "large free fields": "".join(f"GRID*,{i},,{x},{y}\n*,{z}\n" for i, (x, y, z) in
                                 enumerate(X.tolist(), 1)) + free(CARDS[-1:]),
    "tabs": free(CARDS, between="\t"),
    "elements first": small(CARDS[-1:]) + small(CARDS[:-1]) + "SPOINT,99\n",
    "carriage returns": small(CARDS).replace("\n", "\r\n"),
    "sections": "SOL 103\nCEND\nTITLE = a plate\nSUBCASE 1\n  SPC = 1\nBEGIN BULK\n" + small(CARDS)
    + "ENDDATA\nwhatever follows\n",
    "what the scene says": small(CARDS) + "MAT1,1,2.+11,,.3\nPSOLID,7,1\nSPC1,1,123,1,THRU,4\n"
    "FORCE,1,1,,1.,1.,,\nEIGRL,1,,,10\nPARAM,POST,-1\nTEMPD,1,20.\n",
    "underscores of meshio": small(CARDS).replace("CHEXA ", "CHEXA_"),
}  # fmt: skip


def written(folder, text):
    file = folder / "a.bdf"
    file.write_bytes(text.encode())
    return file


def content(folder, text):
    return read_mesh_file(written(folder, text))


@pytest.mark.parametrize("name", SPELLINGS)
def test_every_spelling_is_the_same_mesh(tmp_path, name):
    found = content(tmp_path, SPELLINGS[name])
    order = np.argsort(found.node_numbers)
    assert found.node_numbers[order].tolist() == list(range(1, 9))
    np.testing.assert_allclose(found.points[order], X, rtol=0, atol=1e-16)
    (block,) = found.blocks
    corners = found.points[block.nodes[0]]
    box = KINDS["hexahedron8"].reference * [0.02, 0.015, 0.01] - [0.0, 0.015, 0.0]
    np.testing.assert_allclose(corners, box, rtol=0, atol=1e-16)
    assert {name: rows.tolist() for name, rows in found.element_sets.items()} == {"PSOLID 7": [0]}
    assert MeshFile(str(tmp_path / "a.bdf"), "m").elements.num_cells == 1


EDGES = {
    "CTETRA": ("tetrahedron", "12 23 31 14 24 34"),
    "CPYRAM": ("pyramid", "12 23 34 41 15 25 35 45"),
    "CPENTA": ("wedge", "12 23 31 14 25 36 45 56 64"),
    "CHEXA": ("hexahedron", "12 23 34 41 15 26 37 48 56 67 78 85"),
}
"""Corners between which Nastran's Quick Reference Guide puts the points behind the corners."""


@pytest.mark.parametrize("card", EDGES)
def test_quadratic_elements_have_every_point_where_it_belongs(tmp_path, card):
    cell, edges = EDGES[card]
    at = CORNERS[cell]
    middles = [at[[int(i) - 1 for i in edge]].mean(axis=0) for edge in edges.split()]
    points = np.array([*at, *middles])
    cards = [["GRID", i, "", *x] for i, x in enumerate(points.tolist(), 1)]
    cards.append([card, 1, 1, *range(1, len(points) + 1)])
    (block,) = content(tmp_path, small(cards, "")).blocks
    assert (block.cell, block.order) == (cell, 2)
    nodes = block.nodes[0]
    assert sorted(nodes) == list(range(len(points)))
    np.testing.assert_allclose(points[nodes], KINDS[f"{cell}{len(points)}"].reference, atol=1e-15)


A, B, C = np.array([0.1, 0.2, 0.3]), np.array([0.4, -0.2, 0.9]), np.array([1.0, 0.5, 0.2])


def coordinates(kind, points):
    """Coordinates of points in the system of A, B and C, its axes by Gram and Schmidt."""
    up = (B - A) / np.linalg.norm(B - A)
    along = (C - A) - ((C - A) @ up) * up
    along /= np.linalg.norm(along)
    x, y, z = np.stack([along, np.cross(up, along), up]) @ (points - A).T
    if kind == "R":
        return np.stack([x, y, z], axis=1)
    theta = np.degrees(np.arctan2(y, x))
    if kind == "C":
        return np.stack([np.hypot(x, y), theta, z], axis=1)
    r = np.sqrt(x * x + y * y + z * z)
    return np.stack([r, np.degrees(np.arccos(z / r)), theta], axis=1)


def free_line(*fields):
    return ",".join(repr(float(f)) if isinstance(f, float) else str(f) for f in fields) + "\n"


def system(way, kind):
    """Cards that define the system 5."""
    if way == "2":
        return free_line(f"CORD2{kind}", 5, 0, *A, *B) + free_line("", *C)
    points = "".join(free_line("GRID", 91 + i, 0, *x) for i, x in enumerate((A, B, C)))
    return points + f"CORD1{kind},8,91,92,93,5,91,92,93\n"  # the second of two systems


@pytest.mark.grid
@pytest.mark.parametrize("default", [False, True])
@pytest.mark.parametrize("kind", "RCS")
@pytest.mark.parametrize("way", "12")
def test_points_in_coordinate_systems_are_where_they_were(tmp_path, way, kind, default):
    text = system(way, kind)
    text += "GRDSET,,5\n" if default else ""
    given = enumerate(coordinates(kind, CUBE), 1)
    text += "".join(free_line("GRID", i, "" if default else 5, *x) for i, x in given)
    found = content(tmp_path, text + free(CARDS[-1:]))
    of_cube = found.points[-8:]  # behind those of the system
    np.testing.assert_allclose(of_cube, CUBE, rtol=0, atol=1e-14)


def test_systems_in_systems_and_points_that_leave_the_default(tmp_path):
    """A cylindrical system given in a cylindrical one, and points of the basic system by 0."""
    outer = "CORD2C,1,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
    # A = (1, 90 deg, 0) is (0, 1, 0); B above it; C = (1, 90 deg, ...) turned: (0, 2, 0).
    inner = "CORD2C,2,1,1.,90.,0.,1.,90.,1.\n,2.,90.,0.\n"
    text = "GRDSET,,2\n" + outer + inner
    text += "".join(free_line("GRID", i, 0, *x) for i, x in enumerate(CUBE, 1))
    text += "GRID,9,,1.,0.,0.5\nGRID,10,,1.,90.,0.\n" + free(CARDS[-1:])
    found = content(tmp_path, text)
    np.testing.assert_allclose(found.points[:8], CUBE, atol=1e-15)
    np.testing.assert_allclose(found.points[8:], [[0, 2, 0.5], [-1, 1, 0]], atol=1e-15)


def test_properties_are_sets_and_shells_mark_faces(tmp_path):
    text = free(CARDS) + "CQUAD4,2,3,5,6,7,8\nCTRIA3,3,4,1,2,3\nCHEXA,4,,1,2,3,4,5,6,\n,7,8\n"
    found = content(tmp_path, text + "PCOMP,3,0.\nPLSOLID,7,1\n")
    sets = {name: rows.tolist() for name, rows in found.element_sets.items()}
    assert sets == {"PLSOLID 7": [0], "PSOLID 4": [1], "PSHELL 4": [2], "PCOMP 3": [3]}
    file = written(tmp_path, free(CARDS) + "CQUAD8,2,3,5,6,7,8,,\n")
    with pytest.raises(InputError, match="here are CQUAD8"):
        MeshFile(str(file), "m")
    mesh = MeshFile(str(file), "m", faces={"top": "PSHELL 3"}).mesh(["top"])
    np.testing.assert_allclose(mesh.points[mesh.surfaces["top"]][..., 2], 0.01)


def test_files_are_included_from_their_folder_or_that_of_the_job(tmp_path):
    parts, more = tmp_path / "parts", tmp_path / "parts" / "deep" / "more.bdf"
    more.parent.mkdir(parents=True)
    lines = free(CARDS).splitlines(keepends=True)
    (parts / "points.bdf").write_text("".join(lines[:4]))
    more.write_text("".join(lines[4:8]))
    (parts / "all.bdf").write_text(
        "include 'points.bdf'\nINCLUDE 'parts/deep\n/more.bdf' $ from the folder of the job\n"
    )
    text = "BEGIN BULK\nINCLUDE 'parts\\all.bdf'\n" + "".join(lines[8:])
    np.testing.assert_allclose(content(tmp_path, text).points, X, atol=1e-16)
    more.write_text("INCLUDE '../all.bdf'\n")
    for wrong, told in (
        (text, "include each other"),
        ("INCLUDE none.bdf\n", "an included file"),
        ("INCLUDE '/dev/zero'\n", "a file"),
    ):
        with pytest.raises(InputError, match=told):
            content(tmp_path, wrong)


@pytest.mark.parametrize(
    "card",
    [
        "CELAS2,99,1.+3,1,1", "CBAR,9,1,1,2", "RBE2,9,1,123,2", "MPC,1,1,1,1.,2,1,-1.",
        "CHEXAA,9,1,1,2", "BEGIN,SUPER=1", "PSOLID,7,1,,,,,PFLUID",
    ],
)  # fmt: skip
def test_any_other_card_is_told_and_left_out_by_the_choice_of_a_part(tmp_path, card):
    """Elements of a fluid are no body."""
    file, fluid = str(written(tmp_path, free(CARDS) + card + "\n")), "PFLUID" in card
    name = "CHEXA" if fluid else card.partition(",")[0]
    with pytest.raises(InputError, match=f"here are {name} too") as refused:
        MeshFile(file, "m")
    assert refused.value.field == "part"
    assert fluid or MeshFile(file, "m", part="PSOLID 7").elements.num_cells == 1


GOOD = free(CARDS)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (GOOD.replace("GRID,3,,", "GRID,3,5,"), "CP 5'.* a coordinate system of the file"),
        (GOOD.replace("GRID,3,,", "GRID,2,,"), "a number of a point that occurs once"),
        (GOOD.replace("GRID,3,,", "GRID,3,,nan,"), "a number in field 3 after .* not 'nan'"),
        (GOOD.replace("+,7,8", "+,7,9"), "a number of a point that the file has"),
        (GOOD.replace("+,7,8", "+,7,8,1"), "8 or 20 points"),
        (GOOD.replace("+,7,8", "+,7,8,,,,,,,,,1"), "at most 8 fields"),
        (GOOD + GOOD.splitlines()[-2] + "\n+,7,8\n", "a number of an element that occurs once"),
        ("+,7,8\n" + GOOD, "a line that continues the one before"),
        (GOOD.replace("GRID,3,,", "GRID,3,1,") + "CORD2R,1,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\n",
         "not on one line"),
        (GOOD.replace("GRID,3,,", "GRID,3,1,") + "CORD2R,1,1,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n",
         "not defined by itself"),
        ("GRID,1,,0.,0.,0.\n", "no elements"),
    ],
)  # fmt: skip
def test_what_is_refused(tmp_path, text, words):
    with pytest.raises(InputError, match=words) as refused:
        content(tmp_path, text)
    assert refused.value.field == "file"
