"""What a notebook imports, and what is written of the fields: whole, current, quick to import."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cea.contact.formulations import Greville
from scenes import SceneError, load_scene
from scenes.spec.schema import scene_schema

MU = "contacts.pad_disc.mu"


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
    for name in ("disc_pad", "disc"):
        assert load_scene(make(name)).name == name
    for name in ("mine", "./disc_pad", "disc.toml"):
        with pytest.raises(SceneError, match="disc_pad"):
            load_scene(name)


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
    assert scene.change(MU, 0.3) == load_scene("disc_pad", [f"{MU}=0.3"])


@pytest.mark.parametrize(
    ("value", "told"),
    [(object(), "plain data, or a section of a scene"), ("\ud800", MU)],
)
def test_values_without_a_plain_form_are_refused_where_they_stand(value, told):
    scene = load_scene("disc_pad")
    assert scene.change("name", Path("a") / "b").name == str(Path("a") / "b")
    with pytest.raises(SceneError, match=told):
        scene.change(MU, value)


WRITTEN = {
    "scene_reference.md": ["reference"],
    "scene.schema.json": ["schema"],
    "matrix_scene.schema.json": ["schema", "--matrices"],
}
"""Arguments of `cea scene` by the file of the documentation that they write."""
PROGRAM = """
import json, sys
from comparisons.cli.app import app

for arguments in json.loads(sys.argv[1]):
    app(arguments, standalone_mode=False)
"""


def test_what_is_committed_is_what_the_commands_write(tmp_path):
    """In a process of its own: formulations that other tests register are none of the project."""
    lines = [["scene", *some, "--out", str(tmp_path / file)] for file, some in WRITTEN.items()]
    command = [sys.executable, "-c", PROGRAM, json.dumps(lines)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [line[-1] for line in lines]
    for file, some in WRITTEN.items():
        committed = Path(__file__).parents[2] / "docs" / file
        command = " ".join(["cea scene", *some, f"--out docs/{file}"])
        assert (tmp_path / file).read_text() == committed.read_text(), command


@pytest.mark.parametrize("kind", ["bodies", "matrices"])
def test_every_field_is_explained(kind):
    schema = scene_schema(kind)
    sections = {"scene": schema, **schema["$defs"]}
    silent = [
        f"{name}.{field}"
        for name, section in sections.items()
        for field, spec in section.get("properties", {}).items()
        if not spec.get("description")
    ]
    assert silent == []
    assert '"null"' not in json.dumps(schema)  # TOML has no such value: fields are left out
    assert all(section.get("description") for section in sections.values())
