"""Scenes with modal damping: from fields to modes, changes, matrices, ranks."""

import numpy as np
import pytest
from bad_inputs import complaint
from damped_numbers import modally_damped_disc
from dense_damped_modes import assert_modes_are_dense
from mpi import on_ranks
from scene_mutations import mutations
from scipy.sparse.linalg import spsolve

from cea.errors import InputError
from comparisons.stability.parts.dense_damped import damped_eigenvalues
from scenes import open_result, run_modes, save_result
from scenes.running.assembled import AssembledScene
from scenes.spec.plain import as_data
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene, read_scene

RATIO = "bodies.disc.damping.modal.ratio"


@pytest.mark.parametrize(
    ("backend", "form"),
    [
        ("iga", "saddle"),
        pytest.param("fe", "penalty", marks=pytest.mark.slow),
        pytest.param("fe", "saddle", marks=pytest.mark.slow),
        pytest.param("iga", "penalty", marks=pytest.mark.slow),
    ],
)
def test_modes_are_those_of_dense_matrices(backend, form):
    assert_modes_are_dense(modally_damped_disc(backend, form=form))


@pytest.fixture(scope="module")
def assembled():
    """A scene assembled once."""
    scene = AssembledScene(read_scene(modally_damped_disc("iga")))
    yield scene
    scene.free()


@pytest.mark.parametrize(
    "change",
    [
        {RATIO: 0.1},
        pytest.param({RATIO: 0.0}, marks=pytest.mark.slow),
        pytest.param({"bodies.pad.material.E": 1.3}, marks=pytest.mark.slow),
        {"bodies.pad.damping.alpha": 0.02, "bodies.pad.damping.beta": 0.0},
    ],
)
def test_changes_need_no_assembly(assembled, change, monkeypatch):
    if "bodies.pad.damping.alpha" in change:
        change |= {"bodies.pad.damping.ratios": None, "bodies.pad.damping.frequencies": None}
    expected = run_modes(assembled.scene.change(change))
    monkeypatch.setattr("scenes.running.assembled.run_modes", None)
    found = assembled.modes(change)
    np.testing.assert_allclose(found.eigenvalues, expected.eigenvalues, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    "change",
    [
        {"bodies.disc.material.E": 2.5},
        pytest.param({"bodies.disc.material.rho": 0.8}, marks=pytest.mark.slow),
        pytest.param({"bodies.disc.damping.modal.max_frequency": 0.3}, marks=pytest.mark.slow),
        pytest.param({"bodies.pad.damping.modal.ratios": [0.05]}, marks=pytest.mark.slow),
        pytest.param({"bodies.pad.damping.modal": None}, marks=pytest.mark.slow),
    ],
)
def test_other_changes_find_the_modes_anew(assembled, change):
    expected = run_modes(assembled.scene.change(change)).eigenvalues
    before = assembled.modes().eigenvalues
    found = assembled.modes(change).eigenvalues
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
    assert len(found) != len(before) or np.abs(found - before).max() > 1e-6


def test_thresholds_do_not_cross_materials(assembled):
    with pytest.raises(InputError, match=r"bodies\.disc\.material\.E"):
        assembled.threshold("bodies.disc.material.E", real=2.5, flutter=1.5)


@pytest.mark.slow
def test_a_threshold_in_the_ratio_is_where_growth_begins():
    data = modally_damped_disc("iga")
    data["contacts"]["interface"]["sliding"]["mu_slope"] = -3.0
    data["bodies"]["pad"]["damping"] = {"ratios": [0.1, 0.1], "frequencies": [0.1, 0.4]}
    assembled = AssembledScene(read_scene(data))
    threshold = assembled.threshold(RATIO, real=0.5, flutter=0.0)
    assembled.free()
    assert 0.0 < threshold.value < 0.5
    data["bodies"]["disc"]["damping"]["modal"]["ratio"] = threshold.value
    values = damped_eigenvalues(data)
    inside = values.imag <= 2 * np.pi * data["analysis"]["max_frequency"]
    assert values.real[inside].max() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    "name",
    [
        RATIO,
        pytest.param("bodies.pad.damping.modal.ratios", marks=pytest.mark.slow),
        pytest.param("bodies.pad.material.E", marks=pytest.mark.slow),
    ],
)
def test_sensitivities_are_differences(assembled, name):
    result = assembled.modes(left=True)
    step = 1e-4 * result.modes.values[name]
    values = [result.modes.values[name] + s * step for s in (1, -1)]
    ends = [assembled._driver.solve(0.3, {name: value}).eigenvalues for value in values]
    slopes = (ends[0] - ends[1]) / (2 * step)
    np.testing.assert_allclose(
        result.modes.sensitivity(name), slopes, atol=1e-4 * np.abs(slopes).max()
    )


def test_matrices_hold_all_of_the_damping(assembled):
    result = assembled.modes({RATIO: 0.1})
    matrices = result.matrices()
    assert list(matrices) == ["K", "M", "K_n", "K_f", "C", "Y", "W", "L", "N", "J"]
    x, value = result.modes.vectors[:, 3], result.eigenvalues[3]
    M, W = matrices["M"], matrices["W"]
    D, K = matrices["C"] + matrices["Y"], matrices["K"] + matrices["K_n"] - matrices["K_f"]
    drag = D @ x + W @ (W.T @ x)
    carried = matrices["L"] @ spsolve(matrices["N"].tocsc(), matrices["J"] @ x)
    defect = value**2 * (M @ x) + value * drag + K @ x + carried
    assert np.linalg.norm(defect) < 1e-10 * np.linalg.norm(K @ x)
    assert np.linalg.norm(carried) > 1e-6 * np.linalg.norm(K @ x)
    assert np.linalg.norm(value * (W @ (W.T @ x))) > 1e-6 * np.linalg.norm(K @ x)


def test_results_are_stored_and_opened(tmp_path, assembled):
    result = assembled.modes()
    opened = open_result(save_result(result, tmp_path / "result.json"))
    np.testing.assert_array_equal(opened.eigenvalues, result.eigenvalues)
    assert opened.scene == result.scene


def test_modal_damping_is_damping(assembled):
    assert assembled.scene.damped
    nothing = {
        RATIO: 0.0,
        "bodies.pad.damping": None,
        "contacts.interface.sliding": None,
    }
    assert not assembled.scene.change(nothing).damped
    assert "damping" not in assembled.modes().skipped


def test_scenes_without_it_are_the_data_they_were():
    assert "modal" not in as_data(load_scene("disc_pad_damped"))["bodies"]["pad"]["damping"]


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({RATIO: 1.0}, r"bodies\.disc\.damping\.modal\.ratio"),
        ({RATIO: "much"}, r"bodies\.disc\.damping\.modal\.ratio"),
        ({"bodies.disc.damping.modal.max_frequency": -1.0}, r"modal\.max_frequency"),
        ({"bodies.disc.damping.modal": {}}, r"bodies\.disc\.damping\.modal\.ratio"),
        ({"bodies.disc.damping.modal.mode": 1}, r"bodies\.disc\.damping\.modal\.mode"),
        ({"bodies.pad.damping.modal.ratios": []}, r"bodies\.pad\.damping\.modal\.ratios"),
        ({"bodies.pad.damping.modal.frequencies": [1.0]}, r"modal\.frequencies"),
        ({"bodies.disc.damping.modal": None}, r"bodies\.disc\.damping\.ratios"),
    ],
)
def test_what_cannot_be_is_refused(change, named):
    with pytest.raises(SceneError, match=named):
        read_scene(modally_damped_disc("iga")).change(change)


@pytest.mark.slow
def test_bad_values_are_refused_by_name():
    table = modally_damped_disc("iga")
    table["bodies"]["pad"]["damping"]["modal"] |= {"ratios": [0.1, 0.2], "frequencies": [0.1, 0.5]}
    tried = [
        bad
        for data in (modally_damped_disc("iga"), table)
        for bad in mutations(data)
        if bad.place and "modal" in bad.place
    ]
    assert len(tried) > 200
    assert not [told for bad in tried if (told := complaint(bad, read_scene))]


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("ranks", "backend"),
    [
        (2, "fe"),
        pytest.param(2, "iga", marks=pytest.mark.slow),
        pytest.param(3, "fe", marks=pytest.mark.slow),
        pytest.param(3, "iga", marks=pytest.mark.slow),
    ],
)
def test_numbers_do_not_depend_on_the_ranks(ranks, backend):
    alone, together = (on_ranks(n, "damped_numbers.modal_of_backend", backend) for n in (1, ranks))
    assert alone["modes"] == together["modes"]
    assert min(alone["modes"]) > 3
    for key in ("traces", "re", "im", "slopes"):
        np.testing.assert_allclose(together[key], alone[key], rtol=1e-9, atol=1e-9)
