"""Start-up: a command brings in what it uses, and says which extra it misses."""

import json
import resource
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from comparisons.cli import options as extras

ROOT = Path(__file__).parents[2]
SOLVERS = {"petsc4py", "slepc4py", "mpi4py", "dolfinx_solver", "dolfinx"}
DRAWING = {"matplotlib", "pyvista", "vtkmodules", "PIL"}
ALL = SOLVERS | DRAWING | {"gmsh", "flint", "scipy", "numpy", "pydantic", "rich", "jinja2"}

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


def brought_in(*arguments):
    """Top-level modules in memory when a command has ended, and how it ended."""
    command = [sys.executable, "-c", PROGRAM, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    code, modules = json.loads(done.stdout.splitlines()[-1])
    return code, set(modules)


@pytest.mark.parametrize("arguments", [["--help"], ["exact", "--help"]])
def test_help_brings_in_nothing_but_the_command_line(arguments):
    code, modules = brought_in(*arguments)
    assert not code
    assert modules & ALL == set()
    assert modules >= {"typer", "comparisons"}


def test_exact_eigenvalues_need_no_petsc_and_no_pictures():
    arguments = ["exact", "drum", "--m", "2", "--p", "1", "--mu", "0.3", "--count", "1"]
    code, modules = brought_in(*arguments)
    assert not code
    assert "flint" in modules
    assert modules & (SOLVERS | DRAWING | {"gmsh"}) == set()


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("arguments", [["--help"], ["exact", "--help"]])
def test_help_takes_a_moment(arguments):
    """Processor time of the least disturbed of several runs."""
    seconds = []
    for _ in range(5):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [Path(sys.executable).with_name("cea"), *arguments], capture_output=True, check=True
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    assert min(seconds) < 0.2


@pytest.mark.parametrize(
    ("arguments", "module", "extra"),
    [
        (["exact", "drum", "--m", "2"], "flint", "exact"),
        (["study", "agreement"], "pyvista", "pictures"),
        (["paper", "3"], "matplotlib", "pictures"),
        (["study", "accuracy"], "flint", "exact"),
        (["run", "disc", "--set", "output.pictures=1"], "pyvista", "pictures"),
    ],
)
def test_a_missing_extra_is_told_in_one_line(arguments, module, extra, monkeypatch, cea, tmp_path):
    found = extras.find_spec
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name == module else found(name))
    options = [] if arguments[0] == "exact" else ["--out", tmp_path]
    code, _, told = cea(*arguments, *options)
    assert code == 1
    (line,) = told.splitlines()
    assert line.startswith("error: ")
    assert module in line
    assert f"friction-cea[{extra}]" in line
    assert list(tmp_path.iterdir()) == []


def test_extras_are_those_of_the_project_file():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert set(extras._MODULES) < set(project["optional-dependencies"])
    for extra, modules in extras._MODULES.items():
        assert len(project["optional-dependencies"][extra]) == len(modules)
