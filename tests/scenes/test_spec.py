"""Scenes: what is accepted, and that every fault is one clear line before work begins."""

from pathlib import Path

import pytest
from catalogue import MESHED

from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

MU = "contacts.pad_disc.mu"


@pytest.mark.parametrize(("name", "backend"), MESHED)
def test_every_scene_reads_on_the_backends_it_has_meshes_for(name, backend):
    scene = load_scene(Path(name), backend=backend)
    assert scene.name == name
    assert {body.backend for body in scene.bodies.values()} == {backend}


def test_every_fault_is_told_at_once():
    with pytest.raises(SceneError) as caught:
        load_scene(Path("disc_pad"), [f"{MU}=-1", "bodies.pad.material.E=0"])
    assert len(caught.value.faults) == 2
