"""Decks of CalculiX and Abaqus: read back by their keywords."""

import decks
import numpy as np
import pytest
from deck_scenes import ELEMENTS, alone, in_contact

from scenes import run_modes
from scenes.export.decks.bodies import deck_bodies
from scenes.export.decks.write import write_deck


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Disc and pad as decks: their files, and the cards of each."""
    files = write_deck(in_contact(), tmp_path_factory.mktemp("decks"))
    return files, [decks.cards(file) for file in files]


@pytest.mark.parametrize("name", ELEMENTS)
def test_elements_are_those_of_the_mesh_and_right_handed(name, tmp_path):
    scene = alone(*ELEMENTS[name])
    deck = decks.cards(write_deck(scene, tmp_path)[1])
    kind, elements = decks.elements(deck, "part")
    assert kind == name
    x = decks.nodes(deck)
    mesh = deck_bodies(scene)["part"].mesh
    assert len(elements) == len(mesh.cells)
    assert len(x) == len(mesh.points)
    assert set().union(*elements.values()) == set(x)
    volumes = [volume(np.array([x[n] for n in nodes]), kind) for nodes in elements.values()]
    assert min(volumes) > 0
    sides, height = (16, 1.0) if mesh.dim == 2 else (12, 0.05)
    exact = sides * np.sin(2 * np.pi / sides) / 2 * (0.2**2 - 0.1**2) * height
    assert sum(volumes) == pytest.approx(exact, rel=1e-12)
    if name in decks.LINEAR:
        check_middles(x, elements, kind)


def volume(x, kind):
    """Volume of a straight element, or area; negative where it is inside out."""
    kind = decks.LINEAR.get(kind, kind)
    if kind == "C3D4":
        return np.linalg.det(x[1:4] - x[0]) / 6
    if kind == "C3D8":
        bottom, top = (area(x[i : i + 4, :2]) for i in (0, 4))
        assert bottom == pytest.approx(top)
        return bottom * (x[4, 2] - x[0, 2])
    return area(x[: int(kind[3]), :2])


def area(x):
    """Area of a polygon, positive where it runs counterclockwise."""
    following = np.roll(x, -1, axis=0)
    return float((x[:, 0] * following[:, 1] - x[:, 1] * following[:, 0]).sum() / 2)


def check_middles(x, elements, kind):
    """Nodes behind the corners lie in the middle of the edges that the manuals name."""
    ends = {"C3D10": "12 23 31 14 24 34", "CPE6": "12 23 31"}[kind].split()
    corners = {"C3D10": 4, "CPE6": 3}[kind]
    for nodes in elements.values():
        for middle, (i, j) in zip(nodes[corners:], ends, strict=True):
            expected = (x[nodes[int(i) - 1]] + x[nodes[int(j) - 1]]) / 2
            assert np.allclose(x[middle], expected, atol=1e-15)


def test_a_contact_has_the_stiffness_and_the_sides_of_the_scene(written):
    _, (_, *both) = written
    for deck in both:
        (behaviour,) = decks.of(deck, "SURFACE BEHAVIOR")
        straight = 3 * np.sin(np.radians(40 / 3)) * (0.14**2 - 0.09**2) / 2
        assert float(behaviour.rows[0][0]) == pytest.approx(1e9 / straight, rel=1e-12)
        (pair,) = decks.of(deck, "CONTACT PAIR")
        assert pair.rows == [["pad-bottom", "disc-top"]]
        friction = decks.of(deck, "FRICTION")
        assert float(friction[-1].rows[0][0]) == 0.7
        assert len(decks.of(deck, "CHANGE FRICTION")) == 1


def test_a_model_read_back_is_the_body_that_was_written(written, tmp_path):
    (model, *_), (deck, *_) = written
    scene = in_contact()
    faces = {"pad": ("top", "bottom"), "disc": ("inner", "top")}
    for name, used in faces.items():
        sets = {each: f"{name}-{each}" for each in used}
        file = {"shape": "mesh_file", "file": str(model), "unit": "m", "part": name, "faces": sets}
        scene = scene.change({f"bodies.{name}.geometry": file, f"bodies.{name}.mesh": {}})
    found, before = (run_modes(each).eigenvalues for each in (scene, in_contact()))
    assert found == pytest.approx(before, abs=1e-10 * abs(before).max())
    again = decks.cards(write_deck(scene, tmp_path)[0])
    assert len(decks.nodes(again)) == len(decks.nodes(deck))
    assert decks.faces(again, "pad-bottom", "pad") != []
