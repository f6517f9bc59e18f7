"""Decks of Abaqus: parts, instances, surfaces, sets and files in files."""

import numpy as np
import pytest
from mesh_writers import DECK, by_place

from meshes.mesh_file import MeshFile
from meshes.placement import Placement


@pytest.fixture
def deck(tmp_path):
    file = tmp_path / "deck.inp"
    file.write_text(DECK)
    return str(file)


@pytest.mark.parametrize("instance", ["Cube-1", "Cube-2"])
def test_parts_of_a_deck_are_put_where_their_instances_stand(deck, instance):
    mesh = MeshFile(deck, "m", part=instance).mesh(["Top", "Base"])
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
        ("Held", [[9.5, 0.5, 0.0]]),
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
def test_faces_of_a_deck(deck, sets, middles):
    mesh = MeshFile(deck, "m", part="Cube-2", faces={"wanted": sets}).mesh(["wanted"])
    found = mesh.points[mesh.surfaces["wanted"]].mean(axis=1)
    assert len(found) == len(middles)
    np.testing.assert_allclose(sorted(found.round(9).tolist()), sorted(middles), atol=1e-9)
