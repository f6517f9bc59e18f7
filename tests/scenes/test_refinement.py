"""Scenes refined: elements, degrees, layers where stresses are singular, contacts as mortar."""

import numpy as np
import pytest

from cea.errors import InputError
from scenes import SceneError, load_scene, read_scene, scene_names
from scenes.spec.plain import plain_data, scene_text
from scenes.spec.refinement import (
    Resolution,
    by_direction,
    has_singular_edges,
    moved_to_mortar,
    refined,
    singular_edges,
)

DISC_PAD = load_scene("disc_pad")


def mesh(scene, name):
    """Mesh of a body on its backend."""
    body = scene.bodies[name]
    return body.mesh.fe if body.backend == "fe" else body.mesh.iga


def elements(scene, name):
    return mesh(scene, name).elements


@pytest.mark.parametrize(("degree", "density"), [(4, 2.0), (2, 0.5)])
def test_elements_and_degrees_are_as_asked(backend, degree, density):
    scene = load_scene("blocks").on(backend)
    finer = refined(scene, backend, Resolution(degree, density))
    for name in scene.bodies:
        assert np.max(mesh(finer, name).degree) == degree
        wanted = tuple(max(1, round(density * n)) for n in elements(scene, name))
        assert elements(finer, name) == wanted


def test_contacts_become_mortar_and_that_is_told():
    assert moved_to_mortar(DISC_PAD) == {"pad_disc": "gpts"}
    (contact,) = refined(DISC_PAD, "iga", Resolution(2, 0.5)).contacts.values()
    assert contact.formulation.method == "mortar"


def test_singular_edges_are_clamped_edges_and_boundaries_of_stiff_contacts():
    def towards(scene, name):
        return by_direction([at for edge in singular_edges(scene, name) for at in edge.items()])

    sides = {"r": (0.09, 0.14), "theta": (25.0, 65.0)}
    assert towards(DISC_PAD, "disc") == {"r": (0.06,), "z": (0.0, 0.012)}
    assert towards(DISC_PAD, "pad") == {"z": (0.027,)} | sides
    assert mesh(refined(DISC_PAD, "fe", Resolution(2, 1.0)), "disc").through == sides
    stiff = DISC_PAD.change("contacts.pad_disc.P", 1e13)
    assert towards(stiff, "pad")["z"] == (0.012, 0.027)


@pytest.mark.parametrize("name", ["blocks", "drum", "ring", "drum_3d", "blocks_3d"])
def test_rollers_and_closed_bodies_have_no_singular_edges(name):
    scene = load_scene(name)
    assert not has_singular_edges(scene)
    assert not any(singular_edges(scene, body) for body in scene.bodies)


def test_what_cannot_be_refined_is_refused():
    with pytest.raises(SceneError, match=r"bodies\.disc\.backend"):
        refined(load_scene("ventilated_brake"), "iga", Resolution(2, 1.0))
    with pytest.raises(InputError, match="density"):
        Resolution(2, 0.0)


INFINITE = {"contacts.interface.p": float("inf"), "contacts.interface.form": "saddle"}
ODD = {"description": 'back\\slash, "quotes", ü and\na line'}
TEXTS = {name: load_scene(name) for name in scene_names()} | {
    "layers": refined(DISC_PAD, "fe", Resolution(2, 0.5, 2)),
    "infinity and odd signs": load_scene("blocks").change(INFINITE | ODD),
}


@pytest.mark.parametrize("name", TEXTS)
def test_scenes_are_the_same_when_read_again_from_their_text_and_their_data(name, tmp_path):
    file = tmp_path / "again.toml"
    file.write_text(scene_text(TEXTS[name]))
    assert load_scene(file) == read_scene(plain_data(TEXTS[name])) == TEXTS[name]
