"""Decks of Abaqus: parts, instances, surfaces, sets; mesh files that are refused."""

import numpy as np
import pytest
from mesh_writers import DECK, by_place, file_of

from cea.errors import InputError
from meshes.mesh_file import MeshFile
from meshes.placement import Placement

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
TET10 = "*ELEMENT, TYPE=C3D10, ELSET=TET\n2, 1, 2, 3, 5, 4, 6, 7, 8, 2, 1\n"
AGAIN = "*NODE\n11,0,0,1\n12,1,0,1\n13,1,1,1\n14,0,1,1\n15,0,0,2\n16,1,0,2\n17,1,1,2\n18,0,1,2\n"
AGAIN += "*ELEMENT, TYPE=C3D8, ELSET=NEXT\n3, 11, 12, 13, 14, 15, 16, 17, 18\n"
FAR = AGAIN.replace(",1\n", ",5\n").replace(",2\n", ",6\n")


@pytest.fixture
def read(tmp_path):
    """Reads text as a deck, with fields of the geometry."""

    def read(text, **fields):
        (tmp_path / "cube.inp").write_text(text)
        return MeshFile(str(tmp_path / "cube.inp"), **{"unit": "m"} | fields)

    return read


@pytest.mark.parametrize("instance", ["Cube-1", "Cube-2"])
def test_parts_of_a_deck_are_put_where_their_instances_stand(read, instance):
    mesh = read(DECK, part=instance).mesh(["Top", "Base"])
    turn = Placement(angle=90.0, translation=(10.0, 0.0, 0.0))
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1, 2)], dtype=float)
    expected = cube if instance == "Cube-1" else turn.apply(cube)
    np.testing.assert_allclose(by_place(mesh.points), by_place(expected), atol=1e-14)
    for name, height in (("Top", 2.0), ("Base", 0.0)):
        assert set(mesh.points[mesh.surfaces[name]][0, :, 2]) == {height}


@pytest.mark.parametrize(
    ("sets", "middles"),
    [
        ("Top", [[9.5, 0.5, 2.0]]),
        ("First:S1", [[9.5, 0.5, 0.0]]),
        ("Side", [[10.0, 0.5, 0.5], [10.0, 0.5, 1.5]]),
        ("Some", [[9.5, 0.5, 0.0]]),
        ("Lower", [[9.5, 0.5, 0.0]]),
        ("OfElements", [[9, 0.5, 0.5], [9.5, 0, 0.5], [9.5, 0.5, 0], [9.5, 1, 0.5],
                        [10, 0.5, 0.5]]),
        ("Cube-2.Bottom", [[9.5, 0.5, 0.0]]),
        (("Top", "Held"), [[9.5, 0.5, 0.0], [9.5, 0.5, 2.0]]),
        ("elements:Second", [[9, 0.5, 1.5], [9.5, 0, 1.5], [9.5, 0.5, 2], [9.5, 1, 1.5],
                             [10, 0.5, 1.5]]),
    ],
)  # fmt: skip
def test_faces_of_a_deck(read, sets, middles):
    mesh = read(DECK, part="Cube-2", faces={"wanted": sets}).mesh(["wanted"])
    found = mesh.points[mesh.surfaces["wanted"]].mean(axis=1)
    assert len(found) == len(middles)
    np.testing.assert_allclose(sorted(found.round(9).tolist()), sorted(middles), atol=1e-9)


@pytest.mark.parametrize(
    ("text", "changes", "field", "words"),
    [
        (CUBE + "*NSET, NSET=EDGE\n5, 6\n", {"faces": {"wanted": "EDGE"}}, "faces.wanted",
         "nowhere on the boundary"),
        (CUBE + AGAIN.replace("11, 12, 13, 14", "5, 6, 7, 8") + "*SURFACE, NAME=IN\n1, S2\n",
         {"faces": {"wanted": "IN"}}, "faces.wanted", "between two elements"),
        (CUBE + "*ELSET, ELSET=TOP\n1\n", {"faces": {"wanted": "TOP"}}, "faces.wanted",
         "elements:TOP or nodes:TOP"),
        (CUBE + SHELL, {}, "part", "solid elements alone, here are S4"),
        (CUBE + TET10, {}, "part", "all of order 1 or all of order 2; in cube.inp are: C3D"),
        (CUBE + FAR, {}, "part", "these elements make 2"),
        (CUBE + AGAIN, {}, "part", "make 2 that share no nodes.* merge_nodes: 4 pairs"),
        (CUBE + AGAIN, {"merge_nodes": 0.6}, "merge_nodes", "less than half the shortest edge"),
        (CUBE.replace("2, 3, 4, 5", "2, 4, 3, 5"), {}, "file", "Jacobian is positive"),
        (CUBE.replace("3, 4, 5", "2, 4, 5"), {}, "file", "corners are apart"),
        (CUBE.replace("7, 8\n*NSET", "7, 9\n*NSET"), {}, "file", "a node that the file has"),
        (CUBE.replace("7, 1, 1, 1", "7, 1, nan, 1"), {}, "file", "finite numbers"),
        (CUBE.replace("C3D8,", "C3D8, OFFSET=100,"), {}, "file", "OFFSET=100.*parameters that are"),
        (CUBE.replace("*NODE", "*NODE, SYSTEM=C"), {}, "file", "cartesian"),
        (CUBE + "*NSET, NSET=A\nB\n*NSET, NSET=B\nA\n", {"faces": {"wanted": "A"}}, "file",
         "inside each other"),
        (CUBE + "*NSET, NSET=A, GENERATE\n1, 999999999999999\n", {"faces": {"wanted": "A"}}, "file",
         "first, last"),
        (CUBE + "*SURFACE, NAME=A\n1, S7\n", {"faces": {"wanted": "A"}}, "file", "faces S1 to S6"),
        (CUBE + "*SYMMETRIC MODEL GENERATION, REFLECT=LINE\n", {}, "file", "without this keyword"),
        (CUBE + "*SURFACE, NAME=ALL\nCUBE\n", {"faces": {"up": "TOP", "on": "ALL"}}, "file",
         "'up': .'TOP'., 'on': .'ALL'..: sets of .* 1 faces are on both, the first of element 1"),
        ("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 0, 1\n*ELEMENT, TYPE=CPE3\n1, 1, 2, 3\n", {}, "file",
         "plane z = 0"),
    ],
)  # fmt: skip
def test_what_is_refused(read, text, changes, field, words):
    with pytest.raises(InputError, match=words) as refused:
        read(text, **changes).mesh(changes.get("faces", ()))
    assert refused.value.field == field


def test_shells_may_be_named_as_marks_or_left_out_by_the_choice_of_a_part(read):
    named = read(CUBE + SHELL, faces={"skin": "SKIN"}).mesh(["skin"])
    assert set(named.points[named.surfaces["skin"]][..., 2].ravel()) == {1.0}
    assert len(read(CUBE + SHELL, part="CUBE").mesh(["TOP"]).surfaces["TOP"]) == 1


@pytest.mark.parametrize(
    "keyword",
    ["COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=TOP\n*KINEMATIC", "Equation\n2\n1,1,1,2,1,1",
     "MPC\nBEAM, 1, 2", "RIGID BODY, ELSET=CUBE, REF NODE=1", "TIE, NAME=T\nTOP, TOP",
     "NONSTRUCTURAL MASS, UNITS=TOTAL MASS, ELSET=Cube\n0.5"],
)  # fmt: skip
def test_keywords_that_change_the_body_are_refused_unless_a_part_leaves_them_out(read, keyword):
    """A keyword that names a set of elements belongs to that set."""
    text, name = f"{CUBE}*ELSET, ELSET=ONE\n1\n*{keyword}\n", keyword.upper().splitlines()[0]
    refused = [None, "CUBE"] if "ELSET=CUBE" in name else [None]
    for part in refused:
        with pytest.raises(InputError, match=rf"\*{name.partition(',')[0]} too") as no:
            read(text, part=part)
        assert no.value.field == "part"
    assert len(read(text, part="ONE").mesh(["TOP"]).cells) == 1


def test_keywords_of_the_scene_are_ignored(read):
    """Sections, materials, supports, contacts, loads, output; none of them changes the mesh."""
    lines = ["*SOLID SECTION, ELSET=CUBE, MATERIAL=M", "*MATERIAL, NAME=M", "*ELASTIC", "1, 0.3"]
    lines += ["*TRANSFORM, NSET=TOP, TYPE=C", "0,0,0,0,0,1", "*BOUNDARY", "TOP, 1, 3"]
    lines += ["*CONTACT PAIR, INTERACTION=I", "A, B", "*AMPLITUDE, NAME=A", "0, 0, 1, 1"]
    lines += ["*STEP", "*STATIC", "*MODEL CHANGE, REMOVE", "CUBE", "*NODE FILE", "U", "*END STEP"]
    assert len(read(CUBE + "\n".join(lines)).mesh(["TOP"]).cells) == 1


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.msh", None, "a mesh file"),
        ("folder.msh", "folder", "not a regular file"),
        ("a.step", b"ISO-10303-21;", "one that ends in .msh"),
        ("a.msh", b"*NODE\n1, 0, 0, 0\n", "a .msh file of gmsh"),
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


def test_solids_with_some_middles_of_faces_are_refused_by_their_name(read):
    points = "".join(f"{n}, {n % 2}, {n % 3}, {n}\n" for n in range(1, 16))
    cell = ", ".join(map(str, range(1, 16)))
    with pytest.raises(InputError, match="pyramids, wedges or hexahedra") as no:
        read(f"*NODE\n{points}*ELEMENT, TYPE=C3D15V, ELSET=BODY\n1, {cell}\n", part="BODY")
    assert (no.value.field, no.value.value) == ("file", "cube.inp: C3D15V in the part BODY")
