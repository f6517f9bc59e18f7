"""Pictures of modes: which are drawn, at which phase, and that both bodies are in the frame."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista
from blocks import two_blocks
from matplotlib.image import imread

from scenes import run_scene
from scenes.export.pictures import draw_modes
from scenes.pictures.drawing import Drawing, largest_deflection
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene


def test_largest_deflection_beats_every_phase():
    rng = np.random.default_rng(3)
    shape = rng.normal(size=(40, 3)) + 1j * rng.normal(size=(40, 3))
    complex_shape, largest = largest_deflection(shape)
    real = complex_shape.real
    np.testing.assert_allclose(np.abs(complex_shape), np.abs(shape), rtol=1e-12)
    phases = np.exp(1j * np.linspace(0, 2 * np.pi, 3601))
    swept = np.linalg.norm((shape[:, :, None] * phases).real, axis=1)
    assert np.linalg.norm(real, axis=1).max() == pytest.approx(largest, rel=1e-12)
    assert largest == pytest.approx(swept.max(), rel=1e-5)
    turned, _ = largest_deflection(shape * np.exp(2.1j))
    np.testing.assert_allclose(turned.real, real, atol=1e-12)


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
    return replace(result, spectrum=modes, scene=replace(result.scene, analysis=analysis))


def test_most_unstable_modes_are_drawn_first(result):
    assert len(result.modes.eigenvalues) >= 3
    assert with_growth(result, [0.5, -0.5, 0.9]).most_unstable(5) == [2, 0]
    assert with_growth(result, [0.5, -0.5, 0.9]).most_unstable(1) == [2]
    assert with_growth(result, [0.0]).most_unstable(2) == [0, 1]


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_modes_are_drawn(result, backend, tmp_path):
    (file,) = draw_modes(with_growth(result, [0.0, 0.7]), 1, tmp_path)
    assert file.name == f"mode_{backend}_2.png"
    image = imread(file)[..., :3]
    drawn = np.ptp(image, axis=2) > 0.05
    rows, columns = (np.flatnonzero(drawn[:780].any(axis=axis)) for axis in (1, 0))
    assert np.ptp(rows) > 0.6 * len(image)
    assert drawn.mean() > 0.1
    assert rows.min() > 0
    assert columns.min() > 0
    assert columns.max() < image.shape[1] - 1


def test_images_follow_the_phase():
    square = pyvista.Rectangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]).triangulate()
    # Re(u e^(i phase)) = (cos phase, sin phase): every point runs around a circle.
    square.point_data["real"] = np.tile([1.0, 0.0, 0.0], (square.n_points, 1))
    square.point_data["imaginary"] = np.tile([0.0, -1.0, 0.0], (square.n_points, 1))
    drawing = Drawing.of({"square": square}, "circling")
    phases = np.array([0.0, 0.7, 2.0, 3.5, 5.0])
    centres = []
    for image in drawing.images(phases.tolist(), 2):
        pixels = np.asarray(image)[:380]
        rows, columns = np.nonzero((pixels[..., 2] > 60) & (pixels[..., 0] < 30))
        centres.append(complex(columns.mean(), -rows.mean()))
    # centre = c + r e^(i phase) with one c and r for all phases
    fit, residual, *_ = np.linalg.lstsq(
        np.stack([np.ones(len(phases)), np.exp(1j * phases)], axis=1), np.array(centres), rcond=None
    )
    assert fit[1].real > 10
    assert abs(fit[1].imag) < 0.1 * fit[1].real
    assert np.sqrt(residual[0].real) < 0.1 * fit[1].real


def test_a_static_scene_has_no_modes_to_draw():
    data = two_blocks("iga", {"method": "mortar"}, held=True)
    data |= {"analysis": {"kind": "static"}, "output": {"pictures": 1}}
    with pytest.raises(SceneError, match=r"output\.pictures = 1: 0 in a static analysis"):
        read_scene(data)
