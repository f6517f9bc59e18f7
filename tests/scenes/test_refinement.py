"""Scenes refined: elements, degrees, layers where stresses are singular, contacts as mortar."""

from dataclasses import replace

import numpy as np
import pytest

from cea.errors import InputError
from cea.supports.boundary import Support
from meshes.breaks import breaks_of
from meshes.edge_layers import RATIO
from meshes.shapes import Hub
from scenes import SceneError, load_scene, scene_names
from scenes.refinement.meshes import Resolution, has_singular_edges, moved_to_mortar, refined
from scenes.refinement.singular_edges import singular_edges
from scenes.spec.plain import scene_text

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


def test_closed_bodies_and_asked_boundaries_keep_the_elements_they_need(backend):
    coarse = refined(DISC_PAD, backend, Resolution(2, 0.01))
    assert elements(coarse, "disc") == (3, 6, 1)  # r through 2, theta through 2 and 3 quarters
    assert elements(coarse, "pad") == (1, 1, 1)


def test_sizes_of_tetrahedra_are_divided():
    scene = load_scene("ventilated_brake")
    finer = refined(scene, "fe", Resolution(2, 2.0))
    for name, body in scene.bodies.items():
        assert finer.bodies[name].mesh.fe.size == body.mesh.fe.size / 2
    assert not has_singular_edges(scene)  # no mesh of it follows coordinates


def test_contacts_become_mortar_and_that_is_told():
    assert moved_to_mortar(DISC_PAD) == {"pad_disc": "gpts"}
    (contact,) = refined(DISC_PAD, "iga", Resolution(2, 0.5)).contacts.values()
    assert contact == replace(DISC_PAD.contacts["pad_disc"], formulation=contact.formulation)
    assert contact.formulation.method == "mortar"
    assert moved_to_mortar(load_scene("blocks")) == {}


def test_singular_edges_are_clamped_edges_and_boundaries_of_stiff_contacts():
    disc, pad = (singular_edges(DISC_PAD, name) for name in ("disc", "pad"))
    sides = {"r": (0.09, 0.14), "theta": (25.0, 65.0)}
    assert disc.towards == {"r": (0.06,), "z": (0.0, 0.012)}
    assert pad.towards == {"z": (0.027,)} | sides
    assert disc.through == sides
    stiff = DISC_PAD.change("contacts.pad_disc.P", 1e13)
    assert singular_edges(stiff, "disc").towards["r"] == (0.06, 0.09, 0.14)
    assert singular_edges(stiff, "pad").towards["z"] == (0.012, 0.027)


@pytest.mark.parametrize("name", ["blocks", "drum", "ring", "drum_3d", "blocks_3d"])
def test_rollers_and_closed_bodies_have_no_singular_edges(name):
    scene = load_scene(name)
    assert not has_singular_edges(scene)
    assert not any(singular_edges(scene, body) for body in scene.bodies)


def test_the_edge_of_a_hub_is_re_entrant():
    hub = Hub(0.02, 0.04, 0.1, 0.0, 0.01, -0.02, 0.01)
    scene = load_scene("disc")
    body = replace(scene.bodies["disc"], geometry=hub, supports=(Support("bore"),))
    found = singular_edges(replace(scene, bodies={"disc": body}), "disc")
    assert 0.04 in found.towards["r"]
    assert 0.0 in found.towards["z"]


def test_layers_of_splines_lie_towards_singular_edges():
    plain, scene = (refined(DISC_PAD, "iga", Resolution(2, 0.5, n)) for n in (0, 2))
    through = mesh(scene, "disc").through
    r, _, z = breaks_of(scene.bodies["disc"].geometry, elements(scene, "disc"), through)
    sizes = np.diff(r)
    first = sizes[:3].sum()
    assert sizes[:2] / first == pytest.approx([RATIO**2, RATIO - RATIO**2])
    assert sizes[3] == pytest.approx(first, rel=0.5)  # as even as before
    assert np.allclose(np.diff(z), np.diff(z)[::-1])  # towards both faces alike
    assert elements(scene, "disc")[0] == elements(plain, "disc")[0] + 2


def test_layers_of_lagrange_cells_lie_at_the_edges_alone():
    plain, scene = (refined(DISC_PAD, "fe", Resolution(2, 0.5, n)) for n in (0, 2))
    assert elements(scene, "disc") == elements(plain, "disc")
    disc = scene.bodies["disc"].geometry
    ends = [{"r": disc.inner_radius, "z": z} for z in (disc.bottom, disc.top)]
    assert (mesh(scene, "disc").layers, list(mesh(scene, "disc").edges)) == (2, ends)
    # Edges of the pad run along all its directions: whole layers of elements.
    assert (mesh(scene, "pad").layers, mesh(scene, "pad").edges) == (0, ())
    counts = elements(scene, "pad"), elements(plain, "pad")
    assert all(a > b for a, b in zip(*counts, strict=True))


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
def test_scenes_are_the_same_when_read_again_from_their_text(name, tmp_path):
    file = tmp_path / "again.toml"
    file.write_text(scene_text(TEXTS[name]))
    assert load_scene(file) == TEXTS[name]
