"""The field reference and the JSON Schema: current and whole."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from scenes.spec.schema import scene_schema

DOCS = Path(__file__).parents[2] / "docs"
KINDS = {"bodies": "scene.schema.json", "matrices": "matrix_scene.schema.json"}


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
    assert '"null"' not in json.dumps(schema)  # TOML has no such value: fields are left out
    assert all(section.get("description") for section in sections.values())
