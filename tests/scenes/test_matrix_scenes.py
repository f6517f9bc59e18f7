"""Scenes of matrices: their modes beside dense eigenvalues, what is stored, and what is refused."""

import numpy as np
import pytest
from matrix_files import dense, inside, pieces, scene, undamped, write
from scipy.io import mmwrite
from scipy.sparse import csr_array, diags_array

from cea.errors import InputError
from scenes import SceneError, load_matrices, load_scene
from scenes.running.matrices import AssembledMatrices, run_matrices
from scenes.spec.matrices import read_matrix_scene
from scenes.spec.plain import is_of_matrices


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write(tmp_path_factory.mktemp("matrices"), pieces())


@pytest.fixture(scope="module")
def result(folder):
    return run_matrices(read_matrix_scene(scene(folder)), left=True)


def chain(folder, *, stiffness=None, mass=None, n=30):
    """Files M.mtx and K.mtx of a chain of masses, or other matrices in their place."""
    K = diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    mmwrite(folder / "K.mtx", csr_array(K if stiffness is None else stiffness), precision=17)
    mmwrite(folder / "M.mtx", csr_array(np.eye(n) if mass is None else mass), precision=17)
    return undamped("M.mtx", "K.mtx", 0.15, data=str(folder))


def test_a_chain_without_damping_is_a_symmetric_linear_problem(tmp_path):
    result = run_matrices(read_matrix_scene(chain(tmp_path)))
    true = 2 * np.sin(np.arange(1, 31) * np.pi / 62)
    true = true[true <= 2 * np.pi * 0.15]
    np.testing.assert_allclose(result.eigenvalues, 1j * true, rtol=1e-11)
    assert result.verdict == "stable"
    assert result.modes.window.symmetric_count is not None
    assert "damping" in result.skipped
    assert "unsymmetric solver" in result.skipped
    assert {"pictures", "paraview"} <= set(result.skipped)
    assert not result.warnings


def test_damped_gyroscopic_circulatory_modes_are_all_those_of_lapack(result):
    true = inside(dense(pieces()))
    assert len(true) >= 8
    np.testing.assert_allclose(result.eigenvalues, true, rtol=1e-9)
    assert result.verdict == "unstable"
    assert (true.real > 1e-3).any()
    kinds = {name: piece.symmetry for name, piece in result.pieces.items()}
    assert kinds == dict.fromkeys("MDKQ", "symmetric") | {"G": "skew", "F": "general"}


def test_what_is_symmetric_to_rounding_is_taken_so_and_told(tmp_path):
    K = diags_array([-np.ones(29), 2 * np.ones(30), -np.ones(29)], offsets=[-1, 0, 1]).toarray()
    K[3, 4] *= 1 + 4e-16
    assert K[3, 4] != K[4, 3]
    result = run_matrices(read_matrix_scene(chain(tmp_path, stiffness=K)))
    (warning,) = result.warnings
    assert warning.kind == "symmetrised"
    assert "K" in warning.data["asymmetry"]
    assert result.modes.window.symmetric_count is not None


def test_files_lie_beside_the_scene_or_where_it_is_said(folder, tmp_path):
    lines = ['name = "c"', 'files = {M = "M.mtx", K = "K.npz"}', "mass = {M = 1}"]
    lines += ["stiffness = {K = 1}", 'analysis = {kind = "cea", max_frequency = 0.6}']
    (folder / "c.toml").write_text("\n".join(lines))
    (tmp_path / "c.toml").write_text("\n".join(lines))
    assert is_of_matrices(folder / "c.toml")
    assert not is_of_matrices("disc")
    expected = run_matrices(load_matrices(folder / "c.toml")).eigenvalues
    for changes in ({"data": folder}, {"overrides": [f"data={folder}"]}):
        found = run_matrices(load_matrices(tmp_path / "c.toml", **changes)).eigenvalues
        np.testing.assert_array_equal(found, expected)
    with pytest.raises(InputError, match=r"files\.M"):
        run_matrices(load_matrices(tmp_path / "c.toml"))
    with pytest.raises(SceneError, match="load_matrices"):
        load_scene(folder / "c.toml")
    with pytest.raises(SceneError, match=r"BMLL00\.mat"):
        load_matrices("tu_berlin")


def with_(value, *path):
    """A change of the data of a scene; None leaves a field out."""

    def change(data):
        for name in path[:-1]:
            data = data[name]
        data[path[-1]] = value
        if value is None:
            del data[path[-1]]

    return change


@pytest.mark.parametrize(
    ("change", "field", "told"),
    [
        (with_(None, "mass"), "mass", "required"),
        (with_({}, "mass"), "mass", "at least one"),
        (with_(None, "analysis"), "analysis", "required"),
        (with_({"kind": "static"}, "analysis"), "analysis.kind", "'cea'"),
        (with_(0.0, "analysis", "max_frequency"), "analysis.max_frequency", "greater than 0"),
        (with_(1.0, "analysis", "min_growth"), "analysis.min_growth", "less than or equal to 0"),
        (with_(1.0, "mass", "X"), "mass.X", "M, D, G, K, F, Q"),
        (with_(None, "stiffness", "Q"), "files.Q", "named in a sum"),
        (with_("v/w", "damping", "G"), "damping.G", "without w"),
        (with_("__import__('os')", "damping", "G"), "damping.G", "is not among sin"),
        (with_("1/(v - 2)", "damping", "G"), "damping.G", "finite value"),
        (with_([1.0], "damping", "G"), "damping.G", "a finite number"),
        (with_("v0", "parameters", "v"), "parameters.v", "without v0"),
        (with_(1.0, "parameters", "pi"), "parameters.pi", "a name"),
        (with_("K.npz", "files", "ｘ"), "files.ｘ", "a name"),
        (with_(3, "files", "K"), "files.K", "a valid string"),
        (with_({"pictures": 1}, "output"), "output", "no such field"),
    ],
)
def test_wrong_scenes_are_refused_by_name(change, field, told):
    data = scene("nowhere")
    change(data)
    with pytest.raises(SceneError) as refused:
        read_matrix_scene(data)
    assert any(f.field == field and told in f.allowed for f in refused.value.faults)


@pytest.mark.parametrize(
    ("matrices", "field", "told"),
    [
        ({"mass": np.eye(29)}, "files.K", "29 rows"),
        ({"mass": np.diag([*np.ones(29), 0.0])}, "mass", "1 unknowns without mass"),
        ({"mass": np.eye(30) + np.diag(2 * np.ones(29), 1)}, "files.M", "symmetric"),
        ({"mass": np.eye(30) + 2 * np.eye(30)[::-1]}, "mass", "15 eigenvalues"),
    ],
)
def test_matrices_that_make_no_problem_are_refused(matrices, field, told, tmp_path):
    data = read_matrix_scene(chain(tmp_path, **matrices))
    with pytest.raises(InputError) as refused:
        run_matrices(data)
    assert refused.value.field == field
    assert told in str(refused.value)


def oscillators(folder):
    """Two oscillators that flutter without damping beyond v = 5."""
    matrices = {"M": np.eye(2), "K": np.diag([4.0, 5.0]), "F": np.array([[0.0, 1.0], [-1.0, 0.0]])}
    for name, matrix in matrices.items():
        mmwrite(folder / f"{name}.mtx", csr_array(matrix), precision=17)
    return undamped("M.mtx", "K.mtx", 1.0, data=str(folder)) | {
        "files": {name: f"{name}.mtx" for name in matrices},
        "parameters": {"v": 1.0, "c": 0.0},
        "damping": {"M": "c"},
        "stiffness": {"K": 1.0, "F": "v/10"},
    }


def test_thresholds_of_matrices_are_the_closed_ones(tmp_path):
    """Kappa = 4.5 +- sqrt(0.25 - v^2/100): modes coalesce at v = 5.

    With damping c a mode of stiffness a + i b grows beyond b = c sqrt(a).
    """
    assembled = AssembledMatrices(read_matrix_scene(oscillators(tmp_path)))
    found = assembled.threshold("parameters.v", 1.0, 8.0)
    assert found.value == pytest.approx(5.0, rel=1e-9)
    assert found.frequency == pytest.approx(np.sqrt(4.5) / (2 * np.pi), rel=1e-6)

    damped = AssembledMatrices(read_matrix_scene(oscillators(tmp_path)).change("parameters.c", 0.1))
    v = 10 * np.sqrt(0.25 + 0.1**2 * 4.5)
    assert damped.threshold("parameters.v", 1.0, 8.0).value == pytest.approx(v, rel=1e-9)
    for arguments, field in (
        (("parameters.w", 1.0, 8.0), "parameters.w"),
        (("parameters.v", 1.0, 2.0), "flutter"),
        (("parameters.v", 8.0, 9.0), "flutter"),
    ):
        with pytest.raises((InputError, SceneError), match=field):
            assembled.threshold(*arguments)
    near = damped.threshold("parameters.v", 1.0, 8.0, frequency=0.3)
    assert near.value == pytest.approx(v, rel=1e-9)
