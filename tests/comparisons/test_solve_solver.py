"""``cea solve --solver``: SLEPc's Krylov-Schur finds what the blocks find."""

import json

import numpy as np
import scipy.io
import scipy.sparse as sp
from typer.testing import CliRunner

from comparisons.cli.app import app


def test_both_solvers_of_matrices_agree(tmp_path):
    stiffness = sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(60, 60)) * 1e4
    files = {"mass": sp.eye_array(60), "stiffness": stiffness}
    given = ["solve", "--max-frequency", "10"]
    for name, matrix in files.items():
        scipy.io.mmwrite(tmp_path / f"{name}.mtx", sp.coo_array(matrix))
        given += [f"--{name}", str(tmp_path / f"{name}.mtx")]
    found = {}
    for solver in ("block", "krylov-schur"):
        out = tmp_path / solver
        result = CliRunner().invoke(app, [*given, "--solver", solver, "--out", str(out)])
        assert result.exit_code == 0, result.output
        data = json.loads((out / "result.json").read_text())
        assert data["inputs"].get("solver", "block") == solver
        found[solver] = [value["im"] for value in data["eigenvalues"]]
    exact = 200 * np.sin(np.arange(1, 61) * np.pi / 122)
    exact = exact[exact < 2 * np.pi * 10]
    for values in found.values():
        np.testing.assert_allclose(values, exact, rtol=1e-9)
