"""Words of modes and runs on six scenes, the same whichever command tells them."""

import re
from importlib.resources import files

import numpy as np
import pytest
from scipy.io import mmread, mmwrite
from scipy.sparse import csr_array
from typer.testing import CliRunner

from cea.eigen import driver, window
from cea.eigen.krylov_schur import KrylovOptions
from comparisons.cli.app import app
from scenes import load_scene, run_modes

DRUM = ["--set", "contacts.interface.mu=3e-4"]
BLOCK = """name = "block"
units = "other"
[bodies.block]
backend = "fe"
geometry = { shape = "rectangle", size = [2.0, 1.0] }
material = { E = 1.0, nu = 0.3, rho = 1.0 }
mesh.fe = { cell = "quadrilateral", degree = 2, elements = [4, 2] }
mesh.iga = { degree = [2, 2], elements = [4, 2] }
"""
HELD = 'supports = [{ surface = "x_min" }]\n'
DAMPED = "damping = { alpha = 0.01, beta = 0.01 }\n"
WINDOW = "[analysis]\nkind = 'cea'\nmax_frequency = "
E_AXIS = "bodies.block.material.E=1:1.1:2"
MATRICES = """name = "matrices"
[files]
M = "M.mtx"
K = "K.mtx"
F = "F.mtx"
[parameters]
mu = 1.0
[mass]
M = 1.0
[stiffness]
K = 1.0
F = "mu"
"""
HERTZ = 1 / (2 * np.pi)

SCENES = {  # scene, axis of sweeps, what each command says
    "drum_verdicts": ("contacts.interface.mu=2e-4:3e-4:2", "11 modes grow slowly"),
    "free body": (E_AXIS, r"3 rigid"),
    "empty window": (E_AXIS, "[Nn]o modes"),
    "damped": (E_AXIS, r"^(?!.*(unstable|undecided|grow slowly)).*stable"),
    "complete up to a growth rate": ("parameters.mu=0.9:1:2", r"^(?!.*unstable \().*stable"),
    "exceptional point": ("parameters.mu=0.9:1:2", "2 undecided"),
}
OF_MATRICES = ("complete up to a growth rate", "exceptional point")
RUN = {
    "drum_verdicts": "; verdict: grows slowly",
    "free body": "; verdict: stable",
    "empty window": r"no modes below 0.001 Hz; the lowest is near 0\.0\d+ Hz",
    "damped": "; verdict: stable",
    "complete up to a growth rate": r"; verdict: no unstable mode found up to a growth rate of \d",
    "exceptional point": "; verdict: undecided",
}
"""What one run says more, on one mesh or on several."""


def write_matrices(folder, **matrices):
    for name, matrix in matrices.items():
        mmwrite(folder / f"{name}.mtx", csr_array(matrix))


@pytest.fixture
def written(request, tmp_path, monkeypatch):
    """The scene, its arguments, and matrices of the same for `cea solve`."""
    name, file = request.param, tmp_path / "scene.toml"
    if name == "drum_verdicts":
        text = files("scenes.catalogue").joinpath("drum.toml").read_text()
        file.write_text(text.replace("growth_threshold = 1e-4\n", ""))
        scene, more, top = str(file), DRUM, 0.45
    elif name == "exceptional point":
        friction = np.zeros((3, 3))
        friction[:2, :2] = [[0.0, 0.125], [-0.125, 0.0]]  # kappa = 0.5 +- 0.125 sqrt(1 - mu^2)
        write_matrices(tmp_path, M=np.eye(3), K=np.diag([0.375, 0.625, 5.0]), F=friction)
        file.write_text(f"{MATRICES}{WINDOW}{HERTZ}\n")
        scene, more, top = str(file), [], HERTZ
    elif name == "complete up to a growth rate":
        few = KrylovOptions(dense_limit=0, max_discs=1)
        monkeypatch.setattr(driver, "KrylovOptions", lambda: few)
        monkeypatch.setattr(window, "field_of_values", lambda *_, **__: None)
        friction = np.zeros((151, 151))
        friction[:2, :2] = [[0.0, 0.1], [-0.1, 0.0]]
        values = np.append([2.0, 2.0], np.linspace(0.5, 1e9, 149))
        write_matrices(tmp_path, M=np.eye(151), K=np.diag(values), F=friction)
        file.write_text(f"{MATRICES}{WINDOW}{HERTZ}\n")
        scene, more, top = str(file), [], HERTZ
    else:
        body = BLOCK + {"free body": "", "empty window": HELD, "damped": HELD + DAMPED}[name]
        top = 0.001 if name == "empty window" else 0.4
        file.write_text(f"{body}{WINDOW}{top}\n")
        scene, more = str(file), []
    if name in OF_MATRICES:
        S = sum(mmread(tmp_path / f"{each}.mtx") for each in "KF")
    else:
        found = run_modes(load_scene(scene, more[1::2])).matrices()
        S = found["K"] + found.get("K_n", 0 * found["K"]) - found.get("K_f", 0 * found["K"])
        write_matrices(tmp_path, **{each: found[each] for each in "MC" if each in found})
    write_matrices(tmp_path, S=S)
    solve = [
        "--mass",
        tmp_path / "M.mtx",
        "--stiffness",
        tmp_path / "S.mtx",
        "--max-frequency",
        top,
    ]
    if (tmp_path / "C.mtx").exists():
        solve += ["--damping", tmp_path / "C.mtx"]
    return name, scene, more, list(map(str, solve))


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "solve", "sweep", "threshold", "converge"])
@pytest.mark.parametrize("written", list(SCENES), indirect=True)
def test_every_command_has_the_same_words(written, command, tmp_path):
    name, scene, more, solve = written
    axis, expected = SCENES[name]
    if command == "converge" and name in OF_MATRICES:
        pytest.skip("matrices have no meshes to refine")
    given = {
        "run": [scene, *more],
        "solve": solve,
        "sweep": [scene, axis, *more],
        "threshold": [scene, axis, *more],
        "converge": [scene, "--digits", "2", *more],
    }[command]
    result = CliRunner().invoke(app, [command, *given, "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    said = next(
        line
        for line in result.output.splitlines()
        if re.search("modes? up to|[Nn]o modes|Most g", line)
    )
    assert re.search(expected, said), said
    if command in ("run", "solve", "converge"):
        assert re.search(RUN[name], said)
    assert re.search("; threshold 1e-4|[Nn]o modes", said)
