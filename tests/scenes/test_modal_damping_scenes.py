"""Scenes with modal damping: from fields to modes, changes, matrices, ranks."""

import numpy as np
import pytest
from damped_numbers import modally_damped_disc
from dense_damped_modes import assert_modes_are_dense
from mpi import on_ranks

from scenes import run_modes
from scenes.running.assembled import AssembledScene
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene

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
