"""Scenes of matrices: their modes beside dense eigenvalues, what is stored, and what is refused."""

import json

import numpy as np
import pytest
from external_data import external
from matrix_files import N, dense, inside, pieces, scene, write
from mpi import on_ranks
from scipy.io import mmwrite, savemat
from scipy.sparse import csr_array, diags_array, save_npz
from scipy.sparse.linalg import norm

from cea.errors import InputError
from scenes import SceneError, load_matrices, load_scene, open_result, save_result
from scenes.running.matrices import AssembledMatrices, run_matrices, unused_parameters
from scenes.spec.files import is_of_matrices
from scenes.spec.matrices import read_matrix_scene

WINDOW = {"kind": "cea", "max_frequency": 0.6}


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
    return {
        "name": "chain",
        "data": str(folder),
        "files": {"M": "M.mtx", "K": "K.mtx"},
        "mass": {"M": 1},
        "stiffness": {"K": 1},
        "analysis": {"kind": "cea", "max_frequency": 0.15},
    }


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


def test_a_matrix_may_stand_in_several_sums(tmp_path):
    """Rayleigh damping C = alpha M + beta K has lambda^2 + (alpha + beta k) lambda + k = 0."""
    data = chain(tmp_path) | {
        "parameters": {"alpha": 0.01, "beta": "0.1/pi"},
        "damping": {"M": "alpha", "K": "beta"},
    }
    result = run_matrices(read_matrix_scene(data))
    k = (2 * np.sin(np.arange(1, 31) * np.pi / 62)) ** 2
    c = 0.01 + 0.1 / np.pi * k
    true = -c / 2 + 1j * np.sqrt(k - c**2 / 4)
    top = 2 * np.pi * 0.15
    true = true[(true.imag <= top) & (true.real >= -0.1 * top)]
    np.testing.assert_allclose(result.eigenvalues, true, rtol=1e-10)
    assert result.verdict == "stable"


def test_damped_gyroscopic_circulatory_modes_are_all_those_of_lapack(result):
    true = inside(dense(pieces()))
    assert len(true) >= 8
    np.testing.assert_allclose(result.eigenvalues, true, rtol=1e-9)
    assert result.verdict == "unstable"
    assert (true.real > 1e-3).any()
    kinds = {name: piece.symmetry.kind for name, piece in result.pieces.items()}
    assert kinds == dict.fromkeys("MDKQ", "symmetric") | {"G": "skew", "F": "general"}


def test_sums_are_those_of_the_formulas_to_the_last_bits(result):
    made, sums = pieces(), result.matrices()
    K = made["K"] + 0.7 * made["F"] + 3 * made["Q"]
    C = 1.5 * made["D"] + 2 * made["G"]
    for name, true in {"M": made["M"], "C": C, "K": K}.items():
        np.testing.assert_allclose(sums[name].toarray(), true, rtol=0, atol=1e-15 * abs(true).max())


@pytest.mark.parametrize("name", ["v", "mu"])
def test_sensitivities_are_those_of_differences(result, folder, name):
    slopes = result.modes.sensitivity(f"parameters.{name}")
    step, assembled = 1e-5, AssembledMatrices(result.scene)
    values = {"v": 2.0, "mu": 0.7}
    up, down = (
        assembled.modes({f"parameters.{name}": values[name] + s * step}).eigenvalues
        for s in (1, -1)
    )
    assembled.free()
    np.testing.assert_allclose(slopes, (up - down) / (2 * step), rtol=0, atol=1e-6)
    assert abs(slopes).max() > 1e-3


def test_other_parameters_need_no_reading(folder):
    made = write(folder, pieces())
    assembled = AssembledMatrices(read_matrix_scene(scene(made)))
    (made / "K.npz").rename(made / "away.npz")
    try:
        for speed in (0.5, 3.0):
            found = assembled.modes({"parameters.v": speed}).eigenvalues
            np.testing.assert_allclose(found, inside(dense(pieces(), speed)), rtol=1e-9)
    finally:
        (made / "away.npz").rename(made / "K.npz")
    with pytest.raises(InputError, match="stiffness"):
        assembled.modes({"stiffness.K": 2.0})
    with pytest.raises(SceneError, match=r"parameters\.v"):
        assembled.modes({"parameters.v": "fast"})
    assembled.free()


def test_unsymmetric_entries_keep_their_bits(tmp_path):
    """The small of two entries decides: kappa = 1 +- sqrt(1e10 * 1e-12)."""
    graded = np.array([[1.0, 1e10], [1e-12, 1.0]])
    data = chain(tmp_path, stiffness=graded, mass=np.eye(2), n=2)
    data["analysis"]["max_frequency"] = 0.3
    found = run_matrices(read_matrix_scene(data)).modes
    true = 1j * np.sqrt([0.9, 1.1])
    assert (np.abs(found.eigenvalues - true) <= 1e-8 + found.growth_uncertainties).all()


def test_a_stiffness_that_is_skew_has_no_symmetric_part_to_begin_with(tmp_path):
    data = chain(tmp_path, stiffness=np.array([[0, 1.0], [-1.0, 0]]), mass=np.eye(2), n=2)
    data["analysis"]["max_frequency"] = 1.0
    result = run_matrices(read_matrix_scene(data))
    true = [-(0.5**0.5) * (1 - 1j), 0.5**0.5 * (1 + 1j)]
    np.testing.assert_allclose(sorted(result.eigenvalues, key=lambda v: v.real), true)


def test_what_is_symmetric_to_rounding_is_taken_so_and_told(tmp_path):
    K = diags_array([-np.ones(29), 2 * np.ones(30), -np.ones(29)], offsets=[-1, 0, 1]).toarray()
    K[3, 4] *= 1 + 4e-16
    assert K[3, 4] != K[4, 3]
    result = run_matrices(read_matrix_scene(chain(tmp_path, stiffness=K)))
    (warning,) = result.warnings
    assert warning.kind == "symmetrised"
    assert "K" in warning.data["asymmetry"]
    assert result.modes.window.symmetric_count is not None


def test_results_are_stored_and_opened_again(result, tmp_path):
    opened = open_result(save_result(result, tmp_path / "result.json"))
    np.testing.assert_array_equal(opened.eigenvalues, result.eigenvalues)
    assert opened.scene == result.scene
    assert opened.table() == result.table()
    assert opened.dofs == N
    stored = json.loads((tmp_path / "result.json").read_text())
    assert stored["matrices"]["G"]["symmetry"] == "skew"
    assert stored["skipped"]["pictures"] == "matrices have no geometry"
    assert repr(opened) == repr(result)


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


def without(*path):
    def change(data):
        for name in path[:-1]:
            data = data[name]
        del data[path[-1]]

    return change


def with_(value, *path):
    def change(data):
        for name in path[:-1]:
            data = data[name]
        data[path[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "field", "told"),
    [
        (without("mass"), "mass", "required"),
        (with_({}, "mass"), "mass", "at least one"),
        (with_({}, "stiffness"), "stiffness", "at least one"),
        (without("analysis"), "analysis", "required"),
        (with_({"kind": "static"}, "analysis"), "analysis.kind", "'cea'"),
        (with_(0.0, "analysis", "max_frequency"), "analysis.max_frequency", "greater than 0"),
        (with_(1e31, "analysis", "max_frequency"), "analysis.max_frequency", "1e+30"),
        (with_(1.0, "analysis", "min_growth"), "analysis.min_growth", "less than or equal to 0"),
        (with_(-1.0, "analysis", "growth_threshold"), "analysis.growth_threshold", "greater"),
        (with_(1.0, "mass", "X"), "mass.X", "M, D, G, K, F, Q"),
        (without("stiffness", "Q"), "files.Q", "named in a sum"),
        (with_("v/w", "damping", "G"), "damping.G", "without w"),
        (with_("__import__('os')", "damping", "G"), "damping.G", "no function"),
        (with_("1/(v - 2)", "damping", "G"), "damping.G", "finite value"),
        (with_([1.0], "damping", "G"), "damping.G", "a finite number"),
        (with_(True, "damping", "G"), "damping.G", "a finite number"),
        (with_(None, "damping", "G"), "damping.G", "a finite number"),
        (with_("v0", "parameters", "v"), "parameters.v", "without v0"),
        (with_("1/0", "parameters", "v"), "parameters.v", "finite"),
        (with_(1.0, "parameters", "pi"), "parameters.pi", "a name"),
        (with_(1.0, "parameters", "a b"), "parameters.a b", "a name"),
        (with_("K.npz", "files", "ｘ"), "files.ｘ", "a name"),
        (with_(3, "files", "K"), "files.K", "text"),
        (with_({"pictures": 1}, "output"), "output", "no such field"),
        (with_({}, "bodies"), "bodies", "no such field"),
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
        ({"mass": -np.eye(30)}, "mass", "30 unknowns without mass"),
        ({"mass": np.eye(30) + np.diag(2 * np.ones(29), 1)}, "files.M", "symmetric"),
        ({"mass": np.ones((30, 30))}, "mass", "positive definite"),
        ({"mass": np.eye(30) + 2 * np.eye(30)[::-1]}, "mass", "15 eigenvalues"),
    ],
)
def test_matrices_that_make_no_problem_are_refused(matrices, field, told, tmp_path):
    data = read_matrix_scene(chain(tmp_path, **matrices))
    with pytest.raises(InputError) as refused:
        run_matrices(data)
    assert refused.value.field == field
    assert told in str(refused.value)


def test_a_mass_is_singular_or_not_whatever_its_units(tmp_path):
    scale = np.diag(np.geomspace(1e-9, 1e9, 30))
    near = np.ones((30, 30)) + 1e-3 * np.eye(30)
    data = read_matrix_scene(chain(tmp_path, mass=scale @ near @ scale))
    AssembledMatrices(data)._check_mass(data.values, AssembledMatrices(data).timer)
    singular = scale @ np.ones((30, 30)) @ scale
    data = read_matrix_scene(chain(tmp_path, mass=0.5 * (singular + singular.T)))
    with pytest.raises(InputError, match="positive definite"):
        run_matrices(data)


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_answers_do_not_depend_on_the_number_of_ranks(ranks, folder, result):
    told = on_ranks(ranks, "matrix_files.on_this_many_ranks", str(folder))
    found = np.array(told["re"]) + 1j * np.array(told["im"])
    np.testing.assert_allclose(found, result.eigenvalues, rtol=1e-9)
    assert told["verdicts"] == result.modes.verdicts()
    assert told["pieces"] == {name: piece.plain() for name, piece in result.pieces.items()}
    sums = {name: float(abs(matrix).sum()) for name, matrix in result.matrices().items()}
    assert told["sums"] == pytest.approx(sums, rel=1e-13)


@pytest.mark.mpi
def test_a_broken_file_is_refused_on_every_rank(tmp_path):
    savemat(tmp_path / "both.mat", {"D": np.eye(2)})
    save_npz(tmp_path / "K.npz", csr_array(np.eye(2)))
    told = on_ranks(2, "matrix_files.refused", str(tmp_path))
    assert told == ["files.M", "files.M"]


PUBLISHED = """
    119.2+26260i  74.83+17400i  5.474+4932i  0.5738+36380i  9.587e-5+5131i  -0.04333+10090i
    -1.122+1409i  -1.433+3521i  -1.834+3337i  -1.913+16340i  -2.367+4038i  -3.983+39190i
    -6.571+22890i
"""


def rounded(value):
    """A number to four digits."""
    return f"{value:.3e}"


@pytest.fixture(scope="module")
def brake():
    folder = external("tu_berlin_brake")
    return run_matrices(load_matrices("tu_berlin", data=folder))


@pytest.mark.slow
def test_published_eigenvalues_of_the_brake_to_every_printed_digit(brake):
    """All thirteen of Re in [-10, 1000], Im in [-50, 42000], five of them unstable, none extra."""
    published = [complex(text.replace("i", "j")) for text in PUBLISHED.split()]
    printed = sorted((rounded(v.real), rounded(v.imag)) for v in published)
    found = sorted((rounded(v.real), rounded(v.imag)) for v in brake.eigenvalues)
    assert found == printed
    assert brake.modes.window.complete
    assert brake.modes.verdicts(0.0).count("unstable") == 5
    assert "undecided" not in brake.modes.verdicts(0.0)


@pytest.mark.slow
def test_backward_errors_of_the_brake(brake):
    """Of the quadratic problem, beside matrices that are summed once more."""
    M, C, K = (brake.matrices()[name] for name in "MCK")
    for value, x in zip(brake.eigenvalues, brake.modes.vectors.T, strict=True):
        defect = value**2 * (M @ x) + value * (C @ x) + K @ x
        size = abs(value) ** 2 * norm(M, 1) + abs(value) * norm(C, 1) + norm(K, 1)
        assert np.linalg.norm(defect) < 1e-10 * size * np.linalg.norm(x)
        assert np.linalg.norm(defect) < 1e-14 * size * np.linalg.norm(x)


@pytest.mark.slow
def test_matrices_of_the_brake_are_as_they_are_described(brake):
    kinds = {name: piece.symmetry.kind for name, piece in brake.pieces.items()}
    assert kinds.pop("KR") == "general"
    assert kinds.pop("DG") == "skew"
    assert set(kinds.values()) == {"symmetric"}
    assert {piece.size for piece in brake.pieces.values()} == {4669}


def chains(folder, **parameters):
    """Two oscillators that flutter without damping beyond v = 4, as those of the examples."""
    matrices = {"M": np.eye(2), "K": np.diag([4.0, 5.0]), "F": np.array([[0.0, 1.0], [-1.0, 0.0]])}
    for name, matrix in matrices.items():
        mmwrite(folder / f"{name}.mtx", csr_array(matrix), precision=17)
    return {
        "name": "two oscillators",
        "data": str(folder),
        "files": {name: f"{name}.mtx" for name in matrices},
        "parameters": {"v": 1.0, "c": 0.0},
        "mass": {"M": 1.0},
        "damping": {"M": "c"},
        "stiffness": {"K": 1.0, "F": "v/10"},
        "analysis": {"kind": "cea", "max_frequency": 1.0},
    }


def test_thresholds_of_matrices_are_the_closed_ones(tmp_path):
    """Kappa = 4.5 +- sqrt(0.25 - v^2/100): modes coalesce at v = 5.

    With damping c a mode of stiffness a + i b grows beyond b = c sqrt(a).
    """
    assembled = AssembledMatrices(read_matrix_scene(chains(tmp_path)))
    found = assembled.threshold("parameters.v", 1.0, 8.0)
    assert found.value == pytest.approx(5.0, rel=1e-9)
    assert found.frequency == pytest.approx(np.sqrt(4.5) / (2 * np.pi), rel=1e-6)

    damped = AssembledMatrices(read_matrix_scene(chains(tmp_path)).change("parameters.c", 0.1))
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


def test_parameters_of_no_coefficient_are_told(tmp_path):
    scene = read_matrix_scene(chains(tmp_path)).change({"parameters.w": 2.0})
    assert set(unused_parameters(scene)) == {"parameters.w"}
    assert not unused_parameters(scene.change("stiffness.F", "v*w/10"))
    decay = scene.change({"stiffness.F": "w", "parameters.v": 0.1, "analysis.min_growth": -1.0})
    assert set(unused_parameters(decay)) == {"parameters.v", "analysis.min_growth"}
    damped = decay.change({"parameters.c": 0.1, "stiffness.F": "v*w"})
    assert not unused_parameters(damped)
    assert unused_parameters(decay).items() <= run_matrices(decay).skipped.items()
