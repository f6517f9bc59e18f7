"""Scenes with modal damping: from fields to modes, changes, matrices, ranks."""

import numpy as np
import pytest
from damped_numbers import modally_damped_disc
from dense_damped_modes import assert_modes_are_dense

from scenes import run_modes
from scenes.running.assembled import AssembledScene
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
