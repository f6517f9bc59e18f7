"""Scenes of matrices: their modes beside dense eigenvalues, what is stored, and what is refused."""

from functools import reduce

import numpy as np
import pytest
from matrix_files import dense, inside, pieces, scene, undamped, write
from scipy.io import mmwrite
from scipy.sparse import csr_array, diags_array

from cea.errors import InputError
from scenes import SceneError, load_matrices, load_scene, read_matrix_scene, run_matrices
from scenes.running.matrices import AssembledMatrices
from scenes.spec.plain import is_of_matrices

CHAIN = diags_array([-np.ones(29), 2 * np.ones(30), -np.ones(29)], offsets=[-1, 0, 1]).toarray()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write(tmp_path_factory.mktemp("matrices"), pieces())


def chain(folder, *, K=CHAIN, M=None):
    """A scene of a chain of masses, or of other matrices in their place, in files."""
    for name, matrix in {"K": K, "M": np.eye(30) if M is None else M}.items():
        mmwrite(folder / f"{name}.mtx", csr_array(matrix), precision=17)
    return read_matrix_scene(undamped("M.mtx", "K.mtx", 0.15, data=str(folder)))


def test_a_chain_without_damping_is_a_symmetric_linear_problem(tmp_path):
    result = run_matrices(chain(tmp_path))
    true = 2 * np.sin(np.arange(1, 31) * np.pi / 62)
    true = true[true <= 2 * np.pi * 0.15]
    np.testing.assert_allclose(result.eigenvalues, 1j * true, rtol=1e-11)
    assert result.verdict == "stable"
    assert result.modes.window.symmetric_count is not None
    assert {"damping", "unsymmetric solver", "pictures", "paraview"} <= set(result.skipped)
    assert not result.warnings


def test_damped_gyroscopic_circulatory_modes_are_all_those_of_lapack(folder):
    result = run_matrices(read_matrix_scene(scene(folder)), left=True)
    true = inside(dense(pieces()))
    assert len(true) >= 8
    np.testing.assert_allclose(result.eigenvalues, true, rtol=1e-9)
    assert result.verdict == "unstable"
    assert (true.real > 1e-3).any()
    kinds = {name: piece.symmetry for name, piece in result.pieces.items()}
    assert kinds == dict.fromkeys("MDKQ", "symmetric") | {"G": "skew", "F": "general"}


def test_what_is_symmetric_to_rounding_is_taken_so_and_told(tmp_path):
    K = CHAIN.copy()
    K[3, 4] *= 1 + 4e-16
    assert K[3, 4] != K[4, 3]
    result = run_matrices(chain(tmp_path, K=K))
    (warning,) = result.warnings
    assert warning.kind == "symmetrised"
    assert "K" in warning.data["asymmetry"]
    assert result.modes.window.symmetric_count is not None


def test_files_lie_beside_the_scene_or_where_it_is_said(folder, tmp_path):
    lines = ['name = "c"', 'files = {M = "M.mtx", K = "K.npz"}', "mass = {M = 1}"]
    lines += ["stiffness = {K = 1}", 'analysis = {kind = "cea", max_frequency = 0.6}']
    for place in (folder, tmp_path):
        (place / "c.toml").write_text("\n".join(lines))
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


@pytest.mark.parametrize(
    ("path", "value", "field", "told"),
    [
        ("mass", None, "mass", "required"),
        ("mass", {}, "mass", "at least one"),
        ("analysis", None, "analysis", "required"),
        ("analysis", {"kind": "static"}, "analysis.kind", "'cea'"),
        ("analysis.max_frequency", 0.0, "analysis.max_frequency", "greater than 0"),
        ("analysis.min_growth", 1.0, "analysis.min_growth", "less than or equal to 0"),
        ("mass.X", 1.0, "mass.X", "M, D, G, K, F, Q"),
        ("stiffness.Q", None, "files.Q", "named in a sum"),
        ("damping.G", "v/w", "damping.G", "without w"),
        ("damping.G", "__import__('os')", "damping.G", "is not among sin"),
        ("damping.G", "1/(v - 2)", "damping.G", "finite value"),
        ("damping.G", [1.0], "damping.G", "a finite number"),
        ("parameters.v", "v0", "parameters.v", "without v0"),
        ("parameters.pi", 1.0, "parameters.pi", "a name"),
        ("files.ｘ", "K.npz", "files.ｘ", "a name"),
        ("files.K", 3, "files.K", "a valid string"),
        ("output", {"pictures": 1}, "output", "no such field"),
    ],
)
def test_wrong_scenes_are_refused_by_name(path, value, field, told):
    """With a field changed, or left out where the value is None."""
    data, (*above, name) = scene("nowhere"), path.split(".")
    section = reduce(dict.get, above, data)
    section[name] = value
    if value is None:
        del section[name]
    with pytest.raises(SceneError) as refused:
        read_matrix_scene(data)
    assert any(f.field == field and told in f.allowed for f in refused.value.faults)


@pytest.mark.parametrize(
    ("mass", "field", "told"),
    [
        (np.eye(29), "files.K", "29 rows"),
        (np.diag([*np.ones(29), 0.0]), "mass", "1 unknowns without mass"),
        (np.eye(30) + np.diag(2 * np.ones(29), 1), "files.M", "symmetric"),
        (np.eye(30) + 2 * np.eye(30)[::-1], "mass", "15 eigenvalues"),
    ],
)
def test_matrices_that_make_no_problem_are_refused(mass, field, told, tmp_path):
    with pytest.raises(InputError) as refused:
        run_matrices(chain(tmp_path, M=mass))
    assert refused.value.field == field
    assert told in str(refused.value)


def test_thresholds_of_matrices_are_the_closed_ones(tmp_path):
    """Kappa = 4.5 +- sqrt(0.25 - v^2/100): modes of two oscillators coalesce at v = 5.

    With damping c a mode of stiffness a + i b grows beyond b = c sqrt(a).
    """
    matrices = {"M": np.eye(2), "K": np.diag([4.0, 5.0]), "F": np.array([[0.0, 1.0], [-1.0, 0.0]])}
    for name, matrix in matrices.items():
        mmwrite(tmp_path / f"{name}.mtx", csr_array(matrix), precision=17)
    data = undamped("M.mtx", "K.mtx", 1.0, data=str(tmp_path)) | {
        "files": {name: f"{name}.mtx" for name in matrices},
        "parameters": {"v": 1.0, "c": 0.0},
        "damping": {"M": "c"},
        "stiffness": {"K": 1.0, "F": "v/10"},
    }
    undamped_scene = read_matrix_scene(data)
    assembled = AssembledMatrices(undamped_scene)
    found = assembled.threshold("parameters.v", 1.0, 8.0)
    assert found.value == pytest.approx(5.0, rel=1e-9)
    assert found.frequency == pytest.approx(np.sqrt(4.5) / (2 * np.pi), rel=1e-6)

    damped = AssembledMatrices(undamped_scene.change("parameters.c", 0.1))
    v = pytest.approx(10 * np.sqrt(0.25 + 0.1**2 * 4.5), rel=1e-9)
    assert damped.threshold("parameters.v", 1.0, 8.0).value == v
    assert damped.threshold("parameters.v", 1.0, 8.0, frequency=0.3).value == v
    for parameter, low, high, field in (
        ("parameters.w", 1.0, 8.0, "parameters.w"),
        ("parameters.v", 1.0, 2.0, "flutter"),
        ("parameters.v", 8.0, 9.0, "flutter"),
    ):
        with pytest.raises((InputError, SceneError), match=field):
            assembled.threshold(parameter, low, high)
