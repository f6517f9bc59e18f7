"""Files that hold one triangle of a symmetric matrix, and matrices as Abaqus writes them."""

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array, save_npz, tril

from cea.errors import InputError
from scenes.running.matrices import run_matrices
from scenes.spec.matrices import read_matrix_scene

N = 6
MASS = csr_array(np.eye(N))
CHAIN = csr_array(1e6 * diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(N, N)))
CLOSED_FORM = 2e3 * np.sin(np.arange(1, N + 1) * np.pi / (2 * N + 2)) / (2 * np.pi)
"""Frequencies (Hz) of a chain of springs and masses, fixed at both ends."""


def scene(mass, stiffness, **fields):
    return {
        "name": "chain",
        "files": {"M": str(mass), "K": str(stiffness)},
        "mass": {"M": 1.0},
        "stiffness": {"K": 1.0},
        "analysis": {"kind": "cea", "max_frequency": 400.0},
        **fields,
    }


def frequencies(data):
    return np.sort(run_matrices(read_matrix_scene(data)).modes.eigenvalues.imag) / (2 * np.pi)


def labelled(matrix, file, nodes=tuple(range(1, N + 1)), header=""):
    """As MATRIX INPUT has it: node and degree of freedom of row and column, entry."""
    whole = matrix.tocoo()
    rows = zip(*whole.coords, whole.data, strict=True)
    lines = [f"{nodes[i]},1, {nodes[j]},1,  {x:.15e}\n" for i, j, x in rows]
    file.write_text(header + "".join(lines))
    return file


def coordinates(matrix, file):
    whole = matrix.tocoo()
    rows = zip(*whole.coords, whole.data, strict=True)
    file.write_text("".join(f"{i + 1} {j + 1} {x:.15e}\n" for i, j, x in rows))
    return file


@pytest.fixture
def mass(tmp_path):
    save_npz(tmp_path / "M.npz", MASS)
    return tmp_path / "M.npz"


@pytest.mark.parametrize("lower", [True, False])
def test_one_triangle_is_refused_until_it_is_said_what_it_is(tmp_path, mass, lower):
    triangle = csr_array(tril(CHAIN)) if lower else csr_array(tril(CHAIN).T)
    save_npz(tmp_path / "K.npz", triangle)
    name = "lower" if lower else "upper"
    with pytest.raises(InputError, match=f"--symmetric .*mirrors the {name} triangle") as refused:
        frequencies(scene(mass, tmp_path / "K.npz"))
    assert refused.value.field == "files.K"
    assert f"entries in its {name} triangle alone" in str(refused.value)
    found = frequencies(scene(mass, tmp_path / "K.npz", symmetric={"K": True}))
    np.testing.assert_allclose(found, CLOSED_FORM, rtol=1e-9)


@pytest.mark.parametrize("header", ["", "** made by another program\n"])
def test_files_of_abaqus_with_labels(tmp_path, header):
    nodes = [40, 3, -2, 7, 5, 100]  # negative ones are internal nodes of Abaqus
    M = labelled(MASS, tmp_path / "job_MASS1.mtx", nodes, header)
    K = labelled(csr_array(tril(CHAIN)), tmp_path / "job_STIF1.mtx", nodes, header)
    np.testing.assert_allclose(frequencies(scene(M, K)), CLOSED_FORM, rtol=1e-9)
    from scenes.matrices.reading import read_labelled

    matrix, labels = read_labelled(K)
    order = np.argsort(nodes)
    assert labels.tolist() == [[n, 1] for n in sorted(nodes)]
    assert abs(matrix - CHAIN[order][:, order]).max() == 0


def test_files_of_abaqus_with_coordinates(tmp_path):
    M, K = coordinates(MASS, tmp_path / "M.mtx"), coordinates(CHAIN, tmp_path / "K.mtx")
    np.testing.assert_allclose(frequencies(scene(M, K)), CLOSED_FORM, rtol=1e-9)
