"""Commands on matrices from files: one run, a sweep, a race with scipy."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from external_data import external
from matrix_files import companion, dense, inside, pieces, scene, write
from mpi import command
from scipy.io import mmwrite
from scipy.sparse import csr_array

from cea.errors import InputError
from comparisons.bench import matrices
from comparisons.study.run import run
from comparisons.sweep import page as sweep_page
from comparisons.sweep.page import read_sweep
from comparisons.sweep.points import read_axis
from comparisons.sweep.spectra import UNSTABLE
from comparisons.sweep.study import Asked
from comparisons.sweep.study import run as run_sweep
from scenes.spec.matrices import read_matrix_scene
from scenes.spec.plain import scene_text

STORED = Path(sweep_page.__file__).with_name("results")
PUBLISHED = """
    119.2 74.83 5.474 0.5738 9.587e-5 -0.04333 -1.122 -1.433 -1.834 -1.913 -2.367 -3.983 -6.571
"""
"""Growth rates of the brake at 2 turns a second."""
SPEEDS = [1.0, 1.5, 2.0, 2.5, 3.0]


def solved(folder, *arguments):
    """What ``cea solve`` stored, and what it printed."""
    done = command(*map(str, ("solve", *arguments, "--out", folder)))
    assert done["code"] == 0, done["err"]
    return json.loads((folder / "result.json").read_text()), done["out"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Files of matrices, and a scene of them that lies elsewhere."""
    folder = write(tmp_path_factory.mktemp("matrices"), pieces())
    (folder / "elsewhere").mkdir()
    text = scene_text(read_matrix_scene(scene()))
    (folder / "elsewhere" / "speed.toml").write_text(text)
    return folder


def in_full(toml, axis, data):
    """A sweep that is solved in full at each value."""
    return run_sweep(Asked(toml, (read_axis(axis),), data=data, why_in_full="--full"), Path(data))


def at(swept, i):
    """Eigenvalues at a value of a sweep."""
    there, spectra = swept.spectra.there[i], swept.spectra
    return spectra.growth[i][there] + 2j * np.pi * spectra.frequency[i][there]


@pytest.fixture(scope="module")
def swept(folder):
    toml = folder / "elsewhere" / "speed.toml"
    return in_full(toml, "parameters.v=1:3:5", str(folder))


def test_solve_takes_matrices_and_writes_a_result(folder, tmp_path):
    made = pieces()
    for name, matrix in {"C": made["D"] + made["G"], "K": made["K"] + made["F"]}.items():
        mmwrite(tmp_path / f"{name}.mtx", csr_array(matrix), precision=17)
    files = ["--mass", folder / "M.mtx", "--stiffness", tmp_path / "K.mtx"]
    files += ["--damping", tmp_path / "C.mtx"]
    window = ["--max-frequency", 0.6, "--min-growth", -1.0, "--growth-threshold", 0.01]
    stored, printed = solved(tmp_path, *files, *window)
    assert "pictures" in printed.partition("left out, not needed: ")[2].splitlines()[0]
    assert printed.startswith("▲ solve: ")
    found = np.array([v["re"] + 1j * v["im"] for v in stored["eigenvalues"]])
    true = companion(made["M"], made["D"] + made["G"], made["K"] + made["F"])
    np.testing.assert_allclose(found, inside(true), rtol=1e-9)
    assert stored["inputs"]["min_growth"] == -1.0
    assert stored["verdict"] == "unstable"


@pytest.mark.parametrize(
    ("arguments", "field", "told"),
    [
        (["run", "tu_berlin"], "data", "do not come with it"),
        (["run", "tu_berlin", "--data", "nowhere"], "files.M", "a file that is there"),
        (["run", "tu_berlin", "--data", "x", "--set", "parameters.Omega=0"], "damping.DR",
         "finite value"),
        (["run", "tu_berlin", "--data", "x", "--backend", "fe"], "backend", "no bodies"),
    ],
)  # fmt: skip
def test_faults_are_told_in_a_line(arguments, field, told, tmp_path):
    done = command(*arguments, "--out", str(tmp_path))
    assert done["code"] == 1
    first = done["err"].splitlines()[0]
    assert first.startswith(f"error: {field} = ")
    assert told in first
    assert not (tmp_path / "result.json").exists()


def test_a_sweep_finds_at_each_value_what_lapack_finds(swept):
    assert swept.points.values[:, 0].tolist() == SPEEDS
    for i, speed in enumerate(SPEEDS):
        np.testing.assert_allclose(at(swept, i), inside(dense(pieces(), speed)), rtol=1e-9)
    assert swept.record["failed"] == []
    assert swept.record["command"] == "sweep"


def test_terminals_without_letters_for_marks_end_no_run(tmp_path):
    for name, matrix in {"M": np.eye(2), "K": np.array([[4.0, 1.0], [-1.0, 4.0]])}.items():
        mmwrite(tmp_path / f"{name}.mtx", csr_array(matrix))
    files = ["--mass", tmp_path / "M.mtx", "--stiffness", tmp_path / "K.mtx"]
    arguments = ["solve", *files, "--max-frequency", "1", "--out", tmp_path]
    done = subprocess.run(
        [Path(sys.executable).with_name("cea"), *map(str, arguments)],
        capture_output=True,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(b"? solve: 2 modes up to 1 Hz: 1 unstable")


def test_a_race_is_one_of_the_same_eigenvalues(folder):
    toml = str(folder / "elsewhere" / "speed.toml")
    options = matrices.Options(toml, data=str(folder), repeats=1)
    result = run(matrices.STUDY, options, folder / "out")
    assert result.failed().empty
    found = matrices.seconds(result)
    assert found["found"].tolist() == found["modes"].tolist() == 2 * [len(inside(dense(pieces())))]
    assert (found["processor"] > 0).all()
    undamped = scene() | {"damping": {}}
    for name in "DG":
        undamped["files"].pop(name)
    (folder / "undamped.toml").write_text(scene_text(read_matrix_scene(undamped)))
    with pytest.raises(InputError, match="damping"):
        matrices.loaded(matrices.Options(str(folder / "undamped.toml"), data=str(folder)))


def test_the_stored_sweep_of_the_brake_passes_through_what_is_published():
    """At 2 turns a second, the ninth of 25 values from 1 to 4."""
    made = read_sweep(STORED)
    assert made.record["inputs"]["data"] == "tu_berlin_brake"
    assert not made.record["failed"]
    np.testing.assert_allclose(made.points.axes[0], np.linspace(2, 8, 25) * np.pi, rtol=1e-15)
    growths = sorted(f"{growth:.3e}" for growth in at(made, 8).real)
    assert growths == sorted(f"{float(growth):.3e}" for growth in PUBLISHED.split())
    unstable = (made.spectra.verdict == UNSTABLE).sum(axis=1)
    assert unstable.tolist() == [4, *[5] * 8, *[6] * 10, *[7] * 6]
    assert len(made.record["thresholds"]) == 3


@pytest.mark.slow
def test_the_stored_sweep_of_the_brake_is_what_is_computed():
    data, ends = str(external("tu_berlin_brake")), f"{2 * np.pi!r}:{8 * np.pi!r}"
    made, stored = in_full("tu_berlin", f"parameters.Omega={ends}:4", data), read_sweep(STORED)
    for i in range(4):
        np.testing.assert_allclose(at(made, i), at(stored, 8 * i), rtol=1e-11)


@pytest.mark.parametrize("option", ["--symmetric", "--no-symmetric"])
def test_solve_is_told_what_a_triangle_is(tmp_path, option):
    """Eigenvalues of [[2, 1], [., 1]]: (3 +- sqrt(5)) / 2 of both triangles, 2 and 1 of one."""
    mmwrite(tmp_path / "M.mtx", csr_array(np.eye(2)))
    mmwrite(tmp_path / "K.mtx", csr_array([[2.0, 1.0], [0.0, 1.0]]), symmetry="general")
    files = ["--mass", tmp_path / "M.mtx", "--stiffness", tmp_path / "K.mtx"]
    refused = command(*map(str, ("solve", *files, "--max-frequency", 1)))
    assert refused["code"] == 1
    assert "--symmetric" in refused["err"]
    stored, _ = solved(tmp_path, *files, "--max-frequency", 1, option)
    values = np.array([value["im"] for value in stored["eigenvalues"]])
    expected = [(3 - 5**0.5) / 2, (3 + 5**0.5) / 2] if option == "--symmetric" else [1, 2]
    np.testing.assert_allclose(np.sort(values**2), expected, rtol=1e-9)
