"""Words of modes and runs on six scenes, the same whichever command tells them."""

import re
from importlib.resources import files

import numpy as np
import pytest
from scipy.io import mmwrite
from scipy.sparse import csr_array

from cea.eigen import driver, window
from cea.eigen.krylov_schur import KrylovOptions
from scenes import load_scene, run_modes

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


def write_matrices(folder, mu, stiffness, friction):
    """M = 1, K and F of a pencil K + mu F; S is the sum."""
    K, F = np.diag(stiffness), np.zeros((len(stiffness), len(stiffness)))
    F[:2, :2] = [[0.0, friction], [-friction, 0.0]]
    for name, matrix in {"M": np.eye(len(K)), "K": K, "F": F, "S": K + mu * F}.items():
        mmwrite(folder / f"{name}.mtx", csr_array(matrix))
    (folder / "scene.toml").write_text(f"{MATRICES}{WINDOW}{HERTZ}\n")


def solve_arguments(name, folder, scene):
    """The same for the command that takes matrices: those of a run where the scene has bodies."""
    top, more = HERTZ, []
    if name not in OF_MATRICES:
        loaded = load_scene(scene[0], scene[2::2])
        found, top = run_modes(loaded).matrices(), loaded.analysis.max_frequency
        S = found["K"] + found.get("K_n", 0 * found["K"]) - found.get("K_f", 0 * found["K"])
        for letter, matrix in (found | {"S": S}).items():
            mmwrite(folder / f"{letter}.mtx", csr_array(matrix))
        more = ["--damping", "C.mtx"] if "C" in found else []
    return ["--mass", "M.mtx", "--stiffness", "S.mtx", "--max-frequency", top, *more]


@pytest.fixture
def written(request, tmp_path, monkeypatch):
    """The name of a scene and its arguments."""
    name, file, more = request.param, tmp_path / "scene.toml", []
    if name == "drum_verdicts":
        text = files("scenes.catalogue").joinpath("drum.toml").read_text()
        file.write_text(text.replace("growth_threshold = 1e-4\n", ""))
        more = ["--set", "contacts.interface.mu=3e-4"]
    elif name == "exceptional point":  # kappa = 0.5 +- 0.125 sqrt(1 - mu^2)
        write_matrices(tmp_path, 1.0, [0.375, 0.625, 5.0], 0.125)
    elif name == "complete up to a growth rate":
        few = KrylovOptions(dense_limit=0, max_discs=1)
        monkeypatch.setattr(driver, "KrylovOptions", lambda: few)
        monkeypatch.setattr(window, "field_of_values", lambda *_, **__: None)
        write_matrices(tmp_path, 1.0, [2.0, 2.0, *np.linspace(0.5, 1e9, 149)], 0.1)
    else:
        body = BLOCK + {"free body": "", "empty window": HELD, "damped": HELD + DAMPED}[name]
        file.write_text(f"{body}{WINDOW}{0.001 if name == 'empty window' else 0.4}\n")
    return name, [str(file), *more]


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "solve", "sweep", "threshold", "converge"])
@pytest.mark.parametrize("written", list(SCENES), indirect=True)
def test_every_command_has_the_same_words(written, command, cea, tmp_path):
    name, scene = written
    if command == "converge" and name in OF_MATRICES:
        pytest.skip("matrices have no meshes to refine")
    axis, expected = SCENES[name]
    arguments = {
        "run": scene,
        "solve": solve_arguments(name, tmp_path, scene) if command == "solve" else [],
        "sweep": [scene[0], axis, *scene[1:]],
        "threshold": [scene[0], axis, *scene[1:]],
        "converge": [scene[0], "--digits", "2", *scene[1:]],
    }[command]
    code, told, fault = cea(command, *arguments, "--out", "out")
    assert not code, fault
    lines = told.splitlines()
    said = next(line for line in lines if re.search("modes? up to|[Nn]o modes|Most g", line))
    assert re.search(expected, said), said
    if command in ("run", "solve", "converge"):
        assert re.search(RUN[name], said)
    assert re.search("; threshold 1e-4|[Nn]o modes", said)
