"""Pictures of modes: which are drawn, at which phase, and that both bodies are in the frame."""

import json
from dataclasses import replace

import numpy as np
import pytest
from conftest import two_blocks
from matplotlib.image import imread
from report_data import small_comparison

from cea.errors import InputError
from comparisons.report import write_report
from comparisons.report.pictures import chosen_modes, draw_modes, largest_deflection
from comparisons.run import run_scene
from comparisons.scene import read_scene


def test_largest_deflection_beats_every_phase():
    rng = np.random.default_rng(3)
    shape = rng.normal(size=(40, 3)) + 1j * rng.normal(size=(40, 3))
    real, largest = largest_deflection(shape)
    phases = np.exp(1j * np.linspace(0, 2 * np.pi, 3601))
    swept = np.linalg.norm((shape[:, :, None] * phases).real, axis=1)
    assert np.linalg.norm(real, axis=1).max() == pytest.approx(largest, rel=1e-12)
    assert largest == pytest.approx(swept.max(), rel=1e-5)
    turned, _ = largest_deflection(shape * np.exp(2.1j))
    np.testing.assert_allclose(turned, real, atol=1e-12)


@pytest.fixture
def result(backend):
    scene = two_blocks(backend, {"method": "gpts", "points": 3}, held=True)
    return run_scene(read_scene(scene))


def with_growth(result, growth):
    """The result with given growth rates of its first modes."""
    eigenvalues = result.modes.eigenvalues.imag * 1j
    eigenvalues[: len(growth)] += growth
    conditions = np.ones_like(result.modes.conditions)
    modes = replace(result.modes, eigenvalues=eigenvalues, conditions=conditions)
    analysis = replace(result.scene.analysis, growth_threshold=0.01)
    return replace(result, modes=modes, scene=replace(result.scene, analysis=analysis))


def test_most_unstable_modes_are_drawn_first(result):
    assert len(result.modes.eigenvalues) >= 3
    assert chosen_modes(with_growth(result, [0.5, -0.5, 0.9]), 5) == [2, 0]
    assert chosen_modes(with_growth(result, [0.5, -0.5, 0.9]), 1) == [2]
    assert chosen_modes(with_growth(result, [0.0]), 2) == [0, 1]


def test_modes_are_drawn_and_put_on_the_page(result, backend, tmp_path):
    unstable = with_growth(result, [0.0, 0.7])
    page = write_report(small_comparison(), {backend: unstable}, tmp_path)
    (name,) = json.loads((tmp_path / "result.json").read_text())["pictures"]
    assert name == f"mode_{backend}_2.png"
    assert name in page.read_text(encoding="utf-8")
    image = imread(tmp_path / name)[..., :3]
    drawn = np.ptp(image, axis=2) > 0.05
    rows, columns = (np.flatnonzero(drawn[:780].any(axis=axis)) for axis in (1, 0))
    assert np.ptp(rows) > 0.6 * len(image)
    assert drawn.mean() > 0.1
    assert rows.min() > 0
    assert columns.min() > 0
    assert columns.max() < image.shape[1] - 1


def test_a_static_scene_has_no_modes_to_draw(result, tmp_path):
    with pytest.raises(InputError, match=r"output\.pictures"):
        draw_modes(replace(result, modes=None), 1, tmp_path)
