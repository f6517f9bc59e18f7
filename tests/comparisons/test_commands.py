"""Commands as a person meets them: what they write and print, and what they bring in."""

import json
import re
import subprocess
import sys

import pytest
from mpi import cea_on_ranks
from PIL import Image

from cea import __version__
from scenes.spec.plain import OF_MATRICES, scene_names


def test_version(cea):
    assert cea("--version") == (0, f"friction-cea {__version__}\n", "")


def test_list_names_every_scene_in_a_line(cea):
    code, out, _ = cea("scene", "list")
    assert code == 0
    _, _, table = out.rpartition("─")
    lines = [line.strip() for line in table.splitlines() if line.strip()]
    assert [line.split()[0] for line in lines] == [*scene_names(), *scene_names(OF_MATRICES)]
    (line,) = (line for line in lines if line.startswith("disc_pad "))
    assert "pad, disc" in line
    assert "A steel disc clamped at its inner rim" in line
    assert float(line.split()[1]) == pytest.approx(18696, rel=0.1)


def test_check_tells_size_and_draws(cea, tmp_path):
    code, out, err = cea("scene", "check", "blocks", "--out", tmp_path)
    assert (code, err) == (0, "")
    for told in ("920 unknowns", "no faults", str(tmp_path / "blocks.png")):
        assert told in out
    assert re.search("left out, not needed: .*newton.*loads", out)
    Image.open(tmp_path / "blocks.png").verify()


def test_check_tells_every_fault(cea, tmp_path):
    wrong = ["--set", "contacts.interface.mue=1", "--set", "bodies.upper.material.E=-1"]
    code, _, err = cea("scene", "check", "blocks", *wrong, "--out", tmp_path)
    assert code == 1
    fields = ["bodies.upper.material.E", "contacts.interface.mue"]
    assert [line.split(" = ")[0] for line in err.splitlines()] == [f"error: {f}" for f in fields]
    tilted = ["--set", "bodies.upper.placement={angle=1.0}", "--no-picture"]
    code, _, err = cea("scene", "check", "blocks", *tilted, "--out", tmp_path)
    assert code == 1
    assert "tilted by up to 1 degrees" in err
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.mpi
def test_check_on_two_ranks_is_told_once(tmp_path):
    done = cea_on_ranks(2, "scene", "check", "blocks", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("920 unknowns") == 1
    assert "168 points (168 inside)" in done.stdout
    assert (tmp_path / "blocks.png").is_file()


SOLVERS = {"petsc4py", "slepc4py", "mpi4py", "dolfinx_solver", "dolfinx", "gmsh"}
DRAWING = {"matplotlib", "pyvista", "vtkmodules", "PIL"}
ALL = SOLVERS | DRAWING | {"flint", "scipy", "numpy", "pydantic", "rich", "jinja2"}
PROGRAM = """
import json, os, sys
from contextlib import redirect_stdout
from comparisons.cli.app import main

sys.argv = ["cea", *sys.argv[1:]]
try:
    with redirect_stdout(open(os.devnull, "w")):
        main()
except SystemExit as end:
    code = end.code
print(json.dumps([code, sorted({name.partition(".")[0] for name in sys.modules})]))
"""


@pytest.mark.parametrize(
    ("line", "needed", "unused"),
    [
        ("--help", {"typer", "comparisons"}, ALL),
        ("exact drum --m 2 --p 1 --mu 0.3 --count 1", {"flint"}, SOLVERS | DRAWING),
    ],
)
def test_a_command_brings_in_what_it_needs(line, needed, unused):
    command = [sys.executable, "-c", PROGRAM, *line.split()]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    code, modules = json.loads(done.stdout.splitlines()[-1])
    assert not code
    assert set(modules) >= needed
    assert set(modules) & unused == set()
