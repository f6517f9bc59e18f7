"""Decks of Abaqus: parts, instances, surfaces, sets and files in files."""

import numpy as np
import pytest
from mesh_writers import by_place

from meshes.mesh_file import MeshFile
from meshes.placement import Placement

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
        ("First:S1", [[9.5, 0.5, 0.0]]),
        ("Side", [[10.0, 0.5, 0.5], [10.0, 0.5, 1.5]]),
        ("Held", [[9.5, 0.5, 0.0]]),
        ("Cube-2.Bottom", [[9.5, 0.5, 0.0]]),
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
