"""The field reference and the JSON Schema: current, whole, and true of the scenes there are."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from json_schema import complaints
from scene_mutations import removed, replaced, valid

from scenes.spec.files import OF_MATRICES, SCENES
from scenes.spec.schema import scene_schema

DOCS = Path(__file__).parents[2] / "docs"
KINDS = {"bodies": "scene.schema.json", "matrices": "matrix_scene.schema.json"}
FILES = [(file, "bodies") for file in sorted(SCENES.glob("*.toml"))]
FILES += [(file, "matrices") for file in sorted(OF_MATRICES.glob("*.toml"))]


def wrong(data, kind="bodies"):
    schema = scene_schema(kind)
    return list(complaints(data, schema, schema))


COMMANDS = {
    "scene_reference.md": ["reference"],
    KINDS["bodies"]: ["schema"],
    KINDS["matrices"]: ["schema", "--matrices"],
}
"""Arguments of `cea scene` by the file of the documentation that they write."""
PROGRAM = """
import json, sys
from comparisons.cli.app import app

for arguments in json.loads(sys.argv[1]):
    app(arguments, standalone_mode=False)
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Folder of what the commands write.

    In a process of its own: formulations that other tests register are none of the project.
    """
    folder = tmp_path_factory.mktemp("docs")
    lines = [["scene", *some, "--out", str(folder / file)] for file, some in COMMANDS.items()]
    command = [sys.executable, "-c", PROGRAM, json.dumps(lines)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [line[-1] for line in lines]
    return folder


@pytest.mark.parametrize("file", COMMANDS)
def test_what_is_committed_is_what_the_command_writes(written, file):
    command = " ".join(["cea scene", *COMMANDS[file], f"--out docs/{file}"])
    assert (written / file).read_text() == (DOCS / file).read_text(), command


@pytest.mark.parametrize(("file", "kind"), FILES, ids=lambda value: getattr(value, "stem", value))
def test_scenes_of_the_catalogue_validate(file, kind):
    assert wrong(tomllib.loads(file.read_text()), kind) == []


@pytest.mark.parametrize("kind", KINDS)
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
    assert all(section.get("description") for section in sections.values())


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("bodies", "pad", "backend"), "fem"),
        (("bodies", "pad", "colour"), "red"),
        (("bodies", "pad", "geometry", "shape"), "cone"),
        (("bodies", "pad", "geometry", "start"), "25"),
        (("bodies", "pad", "mesh", "iga", "degree"), [2, 2, 9]),
        (("bodies", "pad", "supports", 0, "components"), ["w"]),
        (("contacts", "pad_disc", "P"), -1.0),
        (("contacts", "pad_disc", "P"), True),
        (("contacts", "pad_disc", "mu"), [0.3]),
        (("contacts", "pad_disc", "formulation"), {"method": "gpts"}),
        (("contacts", "pad_disc", "friction_direction_on_a"), {"vektor": [1.0]}),
        (("bodies", "pad", "placement"), {"axis": [0.0, 1.0]}),
        (("analysis", "kind"), "static"),
        (("output",), {"pictures": 1.5}),
    ],
)
def test_wrong_scenes_do_not_validate(path, value):
    data = valid("disc_pad")
    data["bodies"]["pad"]["colour"] = data["bodies"]["pad"]["placement"] = data["output"] = {}
    del data["bodies"]["pad"]["colour"]
    assert wrong(replaced(data, path, value))
    assert wrong(removed(valid("disc_pad"), ("bodies", "pad", "material", "nu")))
