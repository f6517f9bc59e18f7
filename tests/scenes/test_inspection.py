"""A scene looked at before it is run says what its run then finds, and solves nothing."""

import numpy as np
import pytest
from bad_inputs import BUILT, changed, coarse
from PIL import Image

from scenes import inspect_scene, load_scene, read_scene, run_modes
from scenes.checking import check as inspection
from scenes.checking.check import told
from scenes.pictures.scene import draw_scene


def scene_of(base, backend, *changes):
    return read_scene(changed(coarse(base, backend, BUILT), changes))


def fail(*arguments, **options):
    raise AssertionError("something was solved or meshed")


def test_what_is_seen_before_is_what_a_run_has(backend):
    scene = scene_of("blocks", backend, "contacts.interface.full_pass=true")
    looked, result = inspect_scene(scene), run_modes(scene)
    assert not looked.faults
    assert looked.dofs == result.system.size
    assert looked.halves.keys() == result.interfaces.keys()
    for name, half in looked.halves.items():
        assert len(half.interface.points) == len(result.interfaces[name].points)
    assert looked.skipped == result.skipped
    assert {w.kind for w in looked.warnings} <= {w.kind for w in result.warnings}


def test_nothing_is_solved(backend, monkeypatch):
    monkeypatch.setattr("cea.eigen.mumps.Mumps.__init__", fail)
    looked = inspect_scene(scene_of("blocks", backend))
    assert not looked.faults
    with pytest.raises(AssertionError, match="something was solved"):
        run_modes(looked.scene)


def test_every_contact_with_a_fault_is_told(backend):
    mortar = {"P": 1e9, "formulation": {"method": "mortar"}}
    scene = load_scene("disc_pad", backend=backend).change(
        {
            "contacts.second": mortar | {"a": "pad.outer", "b": "disc.bottom"},
            "contacts.third": mortar | {"a": "pad.inner", "b": "disc.outer"},
        }
    )
    looked = inspect_scene(scene)
    assert [fault.field for fault in looked.faults] == ["contacts.second", "contacts.third"]
    assert list(looked.halves) == ["pad_disc"]


def test_a_scene_too_large_is_not_meshed(monkeypatch):
    monkeypatch.setattr(inspection, "build_bodies", fail)
    looked = inspect_scene(load_scene("disc", ["bodies.disc.mesh.iga.elements=[2000,80000,300]"]))
    assert [fault.field for fault in looked.faults] == ["bodies.disc.mesh.iga.elements"]
    assert not looked.bodies
    assert any(line.startswith("about ") for line in told(looked))


@pytest.mark.parametrize(
    ("backend", "base"),
    [("fe", "disc_pad"), pytest.param("iga", "blocks", marks=pytest.mark.slow)],
)
def test_the_picture_shows_bodies_supports_and_contacts(backend, base, tmp_path):
    file = draw_scene(inspect_scene(scene_of(base, backend)), tmp_path / "scene.png")
    image = np.asarray(Image.open(file).convert("RGB")).astype(int)
    left, right = np.array_split(image, 2, axis=1)
    dark_blue = (left[..., 2] - left[..., 0] > 15) & (left[..., 0] < 110)
    red = (right[..., 0] > 120) & (right[..., 1] < 90) & (right[..., 2] < 90)
    assert (left < 240).any(axis=2).mean() > 0.1
    assert dark_blue.sum() > 300
    assert red.sum() > 300
