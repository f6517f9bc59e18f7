"""Commands on matrices from files: one run and a sweep."""

import json
from pathlib import Path

import numpy as np
import pytest
from external_data import external
from matrix_files import dense, inside, pieces, scene, write
from petsc_matrices import quadratic_eigenvalues
from scipy.io import mmwrite
from scipy.sparse import csr_array
from sweep_cases import eigenvalues, sweep_of

from comparisons.sweep import page as sweep_page
from comparisons.sweep.page import read_sweep
from comparisons.sweep.spectra import UNSTABLE
from scenes import SceneError
from scenes.spec.matrices import load_matrices, read_matrix_scene
from scenes.spec.plain import scene_text

pytestmark = pytest.mark.usefixtures("files_read_here")
STORED = Path(sweep_page.__file__).with_name("results")
PUBLISHED = """
    119.2 74.83 5.474 0.5738 9.587e-5 -0.04333 -1.122 -1.433 -1.834 -1.913 -2.367 -3.983 -6.571
"""
"""Growth rates of the brake at 2 turns a second."""


def write_here(**files):
    """Write matrices to the working directory; options that name them."""
    options = {"M": "--mass", "K": "--stiffness", "C": "--damping"}
    for name, matrix in files.items():
        mmwrite(f"{name}.mtx", csr_array(matrix), precision=17, symmetry="general")
    return [word for name in files for word in (options[name], f"{name}.mtx")]


def test_solve_takes_matrices_and_writes_a_result(cea, tmp_path):
    made = pieces()
    M, C, K = made["M"], made["D"] + made["G"], made["K"] + made["F"]
    window = ["--max-frequency", 0.6, "--min-growth", -1.0, "--growth-threshold", 0.01]
    code, printed, told = cea("solve", *write_here(M=M, K=K, C=C), *window, "--out", "out")
    assert not code, told
    assert "pictures" in printed.partition("left out, not needed: ")[2].splitlines()[0]
    assert printed.startswith("▲ solve: ")
    stored = json.loads((tmp_path / "out" / "result.json").read_text())
    found = np.array([v["re"] + 1j * v["im"] for v in stored["eigenvalues"]])
    np.testing.assert_allclose(found, inside(quadratic_eigenvalues(M, C, K)), rtol=1e-9)
    assert stored["inputs"]["min_growth"] == -1.0
    assert stored["verdict"] == "unstable"


@pytest.mark.parametrize("option", ["--symmetric", "--no-symmetric"])
def test_solve_is_told_what_a_triangle_is(cea, tmp_path, option):
    """Eigenvalues of [[2, 1], [., 1]]: (3 +- sqrt(5)) / 2 of both triangles, 2 and 1 of one."""
    asked = ["solve", *write_here(M=np.eye(2), K=[[2.0, 1.0], [0.0, 1.0]]), "--max-frequency", 1]
    code, _, told = cea(*asked)
    assert code == 1
    assert "--symmetric" in told
    assert not cea(*asked, option, "--out", "out")[0]
    stored = json.loads((tmp_path / "out" / "result.json").read_text())["eigenvalues"]
    expected = [(3 - 5**0.5) / 2, (3 + 5**0.5) / 2] if option == "--symmetric" else [1, 2]
    assert sorted(value["im"] ** 2 for value in stored) == pytest.approx(expected, rel=1e-9)


def test_a_scene_of_bodies_is_none_of_matrices():
    with pytest.raises(SceneError, match="a scene of matrices"):
        load_matrices("blocks")


def test_a_sweep_finds_at_each_value_what_lapack_finds(tmp_path):
    """The scene lies elsewhere than its files."""
    folder, toml = write(tmp_path, pieces()), tmp_path / "elsewhere" / "speed.toml"
    toml.parent.mkdir()
    toml.write_text(scene_text(read_matrix_scene(scene())))
    swept = sweep_of(toml, ["parameters.v=1:3:5"], folder, data=str(folder), full=True)
    for i, speed in enumerate([1.0, 1.5, 2.0, 2.5, 3.0]):
        np.testing.assert_allclose(eigenvalues(swept, i), inside(dense(pieces(), speed)), rtol=1e-9)
    assert swept.record["failed"] == []


def test_the_stored_sweep_of_the_brake_passes_through_what_is_published():
    """At 2 turns a second, the ninth of 25 values from 1 to 4."""
    made = read_sweep(STORED)
    assert made.record["inputs"]["data"] == "tu_berlin_brake"
    assert not made.record["failed"]
    np.testing.assert_allclose(made.points.axes[0], np.linspace(2, 8, 25) * np.pi, rtol=1e-15)
    growths = sorted(f"{growth:.3e}" for growth in eigenvalues(made, 8).real)
    assert growths == sorted(f"{float(growth):.3e}" for growth in PUBLISHED.split())
    unstable = (made.spectra.verdict == UNSTABLE).sum(axis=1)
    assert unstable.tolist() == [4, *[5] * 8, *[6] * 10, *[7] * 6]
    assert len(made.record["thresholds"]) == 3


@pytest.mark.slow
def test_the_stored_sweep_of_the_brake_is_what_is_computed():
    data, axis = str(external("tu_berlin_brake")), f"parameters.Omega={2 * np.pi!r}:{8 * np.pi!r}:4"
    made = sweep_of("tu_berlin", [axis], data, data=data, full=True)
    stored = read_sweep(STORED)
    for i in range(4):
        np.testing.assert_allclose(eigenvalues(made, i), eigenvalues(stored, 8 * i), rtol=1e-11)
