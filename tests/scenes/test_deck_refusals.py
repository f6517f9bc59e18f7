"""What a deck cannot hold is refused by its field, before anything is written."""

import pytest
from deck_scenes import P2, SLIDING, alone, body, in_contact

from scenes import read_scene
from scenes.export.decks.write import write_deck
from scenes.spec.problems import SceneError

REFUSED = {
    "NURBS": ({"bodies.pad.backend": "iga"}, "bodies.pad.backend = 'iga'"),
    "nodes inside": (
        {"bodies.pad.mesh.fe": {"cell": "hexahedron", "degree": 2, "elements": [2, 3, 1]}},
        "bodies.pad.mesh.fe.degree = 2: 1, or 2 with cell = 'tetrahedron'",
    ),
    "degree": (
        {"bodies.pad.mesh.fe": {**P2, "degree": 3, "elements": [2, 3, 1]}},
        "bodies.pad.mesh.fe.degree = 3",
    ),
    "curved": (
        {"bodies.pad.mesh.fe": {**P2, "geometry_degree": 3, "elements": [2, 3, 1]}},
        "bodies.pad.mesh.fe.geometry_degree = 3",
    ),
    "springs": (
        {"bodies.pad.springs": [{"surface": "top", "stiffness": [1.0, 1.0, 1.0]}]},
        "bodies.pad.springs",
    ),
    "damping": ({"bodies.pad.damping": {"alpha": 1.0}}, "bodies.pad.damping"),
    "rotation": ({"bodies.disc.rotation": {"rate": 1.0}}, "bodies.disc.rotation"),
    "rollers": (
        {"bodies.disc.supports": [{"surface": "inner", "components": ["normal"]}]},
        "bodies.disc.supports.0.components",
    ),
    "field of stiffness": (
        {"contacts.pad_disc.P": None, "contacts.pad_disc.p": "1e11*(1+x)"},
        "contacts.pad_disc.p",
    ),
    "tied": ({"contacts.pad_disc.P": float("inf")}, "contacts.pad_disc.P"),
    "field of friction": ({"contacts.pad_disc.mu": "0.3*(1+x)"}, "contacts.pad_disc.mu"),
    "full pass": ({"contacts.pad_disc.full_pass": True}, "contacts.pad_disc.full_pass"),
    "law": (
        {"contacts.pad_disc.P": None, "contacts.pad_disc.c_n": 1e12},
        "contacts.pad_disc.c_n",
    ),
    "sliding": ({"contacts.pad_disc.sliding": {"speed": 1.0, "pressure": 1e5}}, "pad_disc.sliding"),
    "field of directions": (
        {"contacts.pad_disc.friction_direction_on_a": {"field": ["-y", "x", "0"]}},
        "contacts.pad_disc.friction_direction_on_a",
    ),
    "oblique": (
        {"contacts.pad_disc.friction_direction_on_a": {"vector": [1.0, 0.0, 0.5]}},
        "contacts.pad_disc.friction_direction_on_a",
    ),
    "loads": ({"loads": [{"surface": "disc.bottom", "pressure": 1.0}]}, "loads"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_deck_cannot_hold_is_refused_by_its_field(name, tmp_path):
    changes, told = REFUSED[name]
    with pytest.raises(ValueError, match=r"a deck|a vector, or|sides stay together") as error:
        write_deck(in_contact(**changes), tmp_path)
    assert told in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_names_that_programs_do_not_take_are_refused(tmp_path):
    for name in ("1part", "part+", "teil-ä"):
        data = {"name": "names", "bodies": {name: body("tetrahedron", 1)}}
        scene = read_scene({**data, "analysis": {"kind": "cea", "max_frequency": 1e4}})
        with pytest.raises(SceneError, match="a letter, then at most"):
            write_deck(scene, tmp_path)
    twice = {"part": body("tetrahedron", 1), "Part": body("tetrahedron", 1)}
    data = {"name": "names", "bodies": twice, "analysis": {"kind": "cea", "max_frequency": 1e4}}
    with pytest.raises(SceneError, match="that no other has"):
        write_deck(read_scene(data), tmp_path)


def test_a_node_in_two_frames_is_refused(tmp_path):
    supports = [SLIDING[0], {"surface": "top", "components": ["x"]}]
    with pytest.raises(ValueError, match=r"supports\.1\.components = \['x'\]"):
        write_deck(alone("tetrahedron", 1, supports=supports), tmp_path)


@pytest.mark.parametrize("modes", [0, 10**9])
def test_numbers_of_modes_are_bounded(modes, tmp_path):
    with pytest.raises(ValueError, match="modes"):
        write_deck(in_contact(), tmp_path, modes)
