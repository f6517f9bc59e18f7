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
analysis = { kind = "cea", max_frequency = 0.4 }
[bodies.block]
backend = "fe"
geometry = { shape = "rectangle", size = [2.0, 1.0] }
material = { E = 1.0, nu = 0.3, rho = 1.0 }
mesh.fe = { cell = "quadrilateral", degree = 2, elements = [4, 2] }
mesh.iga = { degree = [2, 2], elements = [4, 2] }
"""
HELD = 'supports = [{ surface = "x_min" }]\n'
BODIES = {
    "free body": BLOCK,
    "empty window": BLOCK.replace("0.4", "0.001") + HELD,
    "damped": BLOCK + HELD + "damping = { alpha = 0.01, beta = 0.01 }\n",
    "drum_verdicts": files("scenes.catalogue")
    .joinpath("drum.toml")
    .read_text()
    .replace("growth_threshold = 1e-4\n", ""),
}
HERTZ = 1 / (2 * np.pi)
MATRICES = f"""name = "matrices"
files = {{ M = "M.mtx", K = "K.mtx", F = "F.mtx" }}
parameters = {{ mu = 1.0 }}
mass = {{ M = 1.0 }}
stiffness = {{ K = 1.0, F = "mu" }}
analysis = {{ kind = "cea", max_frequency = {HERTZ} }}
"""
OF_MATRICES = {
    "complete up to a growth rate": ([2.0, 2.0, *np.linspace(0.5, 1e9, 149)], 0.1),
    "exceptional point": ([0.375, 0.625, 5.0], 0.125),  # kappa = 0.5 +- 0.125 sqrt(1 - mu^2)
}
"""Diagonal of K, and what F has beside it."""

E_AXIS, MU_AXIS = "bodies.block.material.E=1:1.1:2", "parameters.mu=0.9:1:2"
SCENES = {  # axis of sweeps, what each command says, what one run says more
    "drum_verdicts": (
        "contacts.interface.mu=2e-4:3e-4:2", "11 modes grow slowly", "; verdict: grows slowly"),
    "free body": (E_AXIS, r"3 rigid", "; verdict: stable"),
    "empty window": (
        E_AXIS, "[Nn]o modes", r"no modes below 0.001 Hz; the lowest is near 0\.0\d+ Hz"),
    "damped": (
        E_AXIS, r"^(?!.*(unstable|undecided|grow slowly)).*stable", "; verdict: stable"),
    "complete up to a growth rate": (
        MU_AXIS, r"^(?!.*unstable \().*stable",
        r"; verdict: no unstable mode found up to a growth rate of \d"),
    "exceptional point": (MU_AXIS, "2 undecided", "; verdict: undecided"),
}  # fmt: skip


def write(folder, **matrices):
    for name, matrix in matrices.items():
        mmwrite(folder / f"{name}.mtx", csr_array(matrix))


@pytest.fixture
def written(request, tmp_path, monkeypatch):
    """The name of a scene and its arguments."""
    name, file = request.param, tmp_path / "scene.toml"
    file.write_text(BODIES.get(name, MATRICES))
    if name in OF_MATRICES:
        diagonal, friction = OF_MATRICES[name]
        K, F = np.diag(diagonal), np.zeros((len(diagonal),) * 2)
        F[:2, :2] = [[0.0, friction], [-friction, 0.0]]
        write(tmp_path, M=np.eye(len(K)), K=K, F=F, S=K + F)
    if name == "complete up to a growth rate":
        few = KrylovOptions(dense_limit=0, max_discs=1)
        monkeypatch.setattr(driver, "KrylovOptions", lambda: few)
        monkeypatch.setattr(window, "field_of_values", lambda *_, **__: None)
    set_mu = ["--set", "contacts.interface.mu=3e-4"]
    return name, [str(file), *(set_mu if name == "drum_verdicts" else [])]


def solve_arguments(name, folder, scene):
    """The same for the command that takes matrices: those of a run where the scene has bodies."""
    top, more = HERTZ, []
    if name not in OF_MATRICES:
        loaded = load_scene(scene[0], scene[2::2])
        found, top = run_modes(loaded).matrices(), loaded.analysis.max_frequency
        S = found["K"] + found.get("K_n", 0 * found["K"]) - found.get("K_f", 0 * found["K"])
        write(folder, S=S, **found)
        more = ["--damping", "C.mtx"] if "C" in found else []
    return ["--mass", "M.mtx", "--stiffness", "S.mtx", "--max-frequency", top, *more]


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "solve", "sweep", "threshold", "converge"])
@pytest.mark.parametrize("written", list(SCENES), indirect=True)
def test_every_command_has_the_same_words(written, command, cea, tmp_path):
    name, scene = written
    if command == "converge" and name in OF_MATRICES:
        pytest.skip("matrices have no meshes to refine")
    axis, expected, of_runs = SCENES[name]
    arguments = {"run": scene, "converge": [*scene, "--digits", "2"]}.get(
        command, [scene[0], axis, *scene[1:]]
    )
    if command == "solve":
        arguments = solve_arguments(name, tmp_path, scene)
    code, told, fault = cea(command, *arguments, "--out", "out")
    assert not code, fault
    lines = told.splitlines()
    said = next(line for line in lines if re.search("modes? up to|[Nn]o modes|Most g", line))
    assert re.search(expected, said), said
    if command in ("run", "solve", "converge"):
        assert re.search(of_runs, said)
    assert re.search("; threshold 1e-4|[Nn]o modes", said)
