"""What a notebook imports: scenes by name or path, changed with checks, and quick to import."""

import json
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

import scenes
from cea.contact.formulations import Greville
from scenes import SceneError, load_scene, read_scene
from scenes.spec.plain import plain_data, scene_names, tables_of

MU = "contacts.pad_disc.mu"
MESHED = [
    (name, backend)
    for name in scene_names()
    for backend in ("fe", "iga")
    if all(backend in body["mesh"] for body in tables_of(name)["bodies"].values())
]
"""Scenes that come with the project, with the backends that all their bodies have meshes for."""


def test_every_exported_name_is_there():
    assert {"load_scene", "run_scene", "open_result", "assemble", "register"} <= set(scenes.__all__)
    assert all(getattr(scenes, name).__name__ == name for name in scenes.__all__)
    assert set(scenes.__all__) == set(dir(scenes))
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = scenes.no_such_name


def test_importing_is_quick_and_brings_in_nothing_heavy():
    code = (
        "import json, sys, time, scenes\n"
        "imported = time.process_time()\n"
        "scenes.load_scene('disc_pad').change('contacts.pad_disc.mu', 0.3)\n"
        "print(json.dumps([imported, list(sys.modules)]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    seconds, modules = json.loads(done.stdout)
    assert seconds < 0.5
    heavy = {"petsc4py", "dolfinx", "gmsh", "pyvista", "matplotlib", "pandas", "shapely"}
    assert not heavy & set(modules)


@pytest.mark.parametrize("make", [str, Path])
def test_what_lies_in_the_working_directory_never_shadows_a_scene(make, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "disc_pad").mkdir()
    (tmp_path / "disc").write_text("name = 'mine'")
    assert load_scene(make("disc_pad")).name == "disc_pad"
    assert load_scene(make("disc")).name == "disc"
    for name in ("mine", "./disc_pad", "disc.toml"):
        with pytest.raises(SceneError, match="disc_pad"):
            load_scene(name)


def test_all_scenes_but_one_have_meshes_of_both_backends():
    assert {name for name in scene_names() if (name, "iga") not in MESHED} == {"ventilated_brake"}
    assert {name for name, backend in MESHED if backend == "fe"} == set(scene_names())


@pytest.mark.parametrize(("name", "backend"), MESHED)
def test_a_scene_is_its_plain_data(name, backend):
    scene = load_scene(name, backend=backend)
    assert read_scene(plain_data(scene)) == scene
    assert load_scene(name).on(backend) == scene
    assert scene.backends == backend


def test_fields_are_changed_by_their_paths():
    scene = load_scene("disc_pad")
    changed = scene.change(
        {
            MU: np.float64(0.3),
            "contacts.pad_disc.formulation": Greville(),
            "bodies.disc.mesh.iga.elements": np.array([5, 16, 1]),
            "bodies.disc.supports.0.components": ["x"],
            "analysis.max_frequency": 2000,
        }
    )
    assert changed.contacts["pad_disc"].mu == 0.3
    assert changed.contacts["pad_disc"].formulation == Greville()
    assert changed.bodies["disc"].mesh.iga.elements == (5, 16, 1)
    assert changed.bodies["disc"].supports[0].components == ("x",)
    assert changed.analysis.max_frequency == 2000.0
    assert scene == load_scene("disc_pad")
    rest = {"name", "description", "loads", "output"}
    assert all(asdict(changed)[field] == asdict(scene)[field] for field in rest)
    assert scene.change(MU, 0.3) == load_scene("disc_pad", [f"{MU}=0.3"])
