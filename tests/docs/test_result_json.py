"""Every key of real results is documented, and every documented one is that of a real result."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from blocks import two_blocks
from scipy.io import mmwrite
from scipy.sparse import csr_array

from comparisons.cli.run import run
from scenes import read_scene, run_modes, save_result

DOCUMENT = Path(__file__).parents[2] / "docs" / "result_json.md"
LISTS = ("unstable", "eigenvalues")


def documented():
    """Keys in the first column of the tables, by their paths."""
    rows = [line for line in DOCUMENT.read_text("utf-8").splitlines() if line.startswith("| `")]
    return {key for row in rows for key in re.findall(r"`([\w.]+)`", row.split("|")[1])}


def keys_of(file):
    """Keys of a result, those of the entries of its lists too."""
    data = json.loads(file.read_text())
    inner = {f"{name}.{key}" for name in LISTS for row in data.get(name, ()) for key in row}
    return set(data) | inner


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Results of every kind of run."""
    folders = {name: tmp_path_factory.mktemp(name) for name in ("modes", "static", "matrices")}
    coarse = [f"bodies.{body}.mesh.iga.elements=[7, 2]" for body in ("upper", "lower")]
    run("blocks", [*coarse, "output.pictures=1", "output.paraview=1"], out=folders["modes"])
    static = ["contacts.interface.formulation.points=3", "analysis.samples=4"]
    run("patch_test", static, out=folders["static"])
    folder = folders["matrices"]
    for name, matrix in {"M": np.eye(2), "K": np.diag([1.0, 4.0])}.items():
        mmwrite(folder / f"{name}.mtx", csr_array(matrix))
    sums = "[mass]\nM = 1\n[stiffness]\nK = 1\n[analysis]\nkind = 'cea'\nmax_frequency = 1.0\n"
    text = f"name = 'two'\n[files]\nM = 'M.mtx'\nK = 'K.mtx'\n{sums}"
    (folder / "two.toml").write_text(text)
    run(str(folder / "two.toml"), [], out=folder)
    data = two_blocks("iga", {"method": "gpts", "points": 3}, held=True, mu=0.1, P=None)
    data["contacts"]["interface"] |= {"c_n": 5.0}
    data["bodies"]["upper"]["supports"][0]["value"] = [0.0, 0.0, -1e-3]
    data["loads"] = [{"body": "upper", "body_force": [0.0, 0.0, -0.01]}]
    steady = save_result(run_modes(read_scene(data)), folders["modes"] / "steady.json")
    return [folder / "result.json" for folder in folders.values()] + [steady]


def test_what_is_documented_is_what_is_stored(results):
    found = set().union(*map(keys_of, results))
    assert found == documented()


def test_the_summary_tells_what_the_lists_hold(results):
    for file in results:
        data = json.loads(file.read_text())
        values = data.get("eigenvalues", [])
        assert [value["mode"] for value in values] == list(range(1, len(values) + 1))
        unstable = [value["mode"] for value in values if value["verdict"] == "unstable"]
        assert [mode["mode"] for mode in data.get("unstable", [])] == unstable
        assert not values or f"{len(values)} modes up to" in data["summary"]
        assert not unstable or f"{len(unstable)} unstable" in data["summary"]
