"""Each example runs, and one number of it stays what it is."""

from pathlib import Path

import numpy as np
import pytest

from comparisons.converge.request import Request
from comparisons.converge.study import run_converge
from comparisons.study.session import Progress
from examples import (
    brake_sweep,
    compare_formulations,
    exact_errors,
    flutter_threshold,
    friction_sweep,
    matrices_from_files,
    matrices_in_scipy,
    mixed_bodies,
    own_mesh,
    own_scene,
    unstable_modes,
    which_formulation,
)
from scenes import assemble
from scenes.spec.reading import load_scene
from scenes.spec.refinement import has_singular_edges

ROOT = Path(__file__).parents[2]
SAME = 1e-8
"""Relative difference at which numbers are the same."""


def test_unstable_modes():
    ((frequency, growth),) = unstable_modes.unstable_modes()
    assert frequency == pytest.approx(6559.699174715652, rel=SAME)
    assert growth == pytest.approx(332.8704443645315, rel=SAME)


@pytest.mark.slow
def test_formulations():
    assert compare_formulations.largest_growth_rates() == {
        "collocation": pytest.approx(153.21917722552962, rel=SAME),
        "GPTS": pytest.approx(332.87799690711506, rel=SAME),
        "GPTS, lumped": pytest.approx(422.823067723299, rel=SAME),
        "segments": pytest.approx(332.86259393612795, rel=SAME),
        "mortar": pytest.approx(332.88038492205175, rel=SAME),
    }


def test_own_scene():
    assert own_scene.lowest_frequency() == pytest.approx(0.13398734709299248, rel=SAME)


@pytest.mark.slow
def test_own_mesh(tmp_path):
    """The mesh is unstructured: its program may place nodes anew from version to version."""
    result = own_mesh.brake(tmp_path)
    assert result.frequencies.min() == pytest.approx(1731.759, rel=1e-3)
    assert "in millimetres: 16 modes up to 9000 Hz: 3 unstable" in str(result)


@pytest.mark.slow
def test_mixed_bodies():
    assert mixed_bodies.most_unstable_frequency() == pytest.approx(6559.60358017531, rel=SAME)


@pytest.mark.slow
def test_friction_sweep():
    found = friction_sweep.growth_rates(np.array([0.0, 1.0]))
    assert found[0] == 0.0
    assert found[1] == pytest.approx(480.89011511, rel=SAME)


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(
    ("backend", "error"), [("fe", 3.185220321316957e-06), ("iga", 1.066108497603393e-06)]
)
def test_exact_errors(backend, error):
    assert exact_errors.worst_error(backend) == pytest.approx(error, abs=1e-10)


@pytest.mark.slow
def test_flutter_threshold(backend):
    assert flutter_threshold.threshold(backend) == pytest.approx(
        flutter_threshold.exact_threshold(), abs=2e-5
    )


def test_matrices_in_scipy():
    scipy, ours = matrices_in_scipy.eigenvalue_by_scipy()
    assert scipy == pytest.approx(ours, rel=SAME)
    assert ours == pytest.approx(1.374601243291j, rel=SAME)


@pytest.mark.slow
def test_which_formulation():
    """GPTS with enough points is as mortar and segments are; lumping and collocation are not."""
    found = which_formulation.growth_rates(3e11)
    mortar = 399.06110664229936
    assert found["mortar"] == pytest.approx(mortar, rel=SAME)
    for name in ("gpts, 5 points", "segments"):
        assert found[name] == pytest.approx(mortar, rel=1e-4)
    for name in ("greville", "gpts, lumped"):
        assert abs(found[name] - mortar) > 0.04 * mortar


@pytest.mark.slow
def test_brake_sweep(tmp_path):
    brake = assemble(brake_sweep.SCENE)
    threshold = brake.threshold(brake_sweep.MU, real=0.0, flutter=0.5).value
    assert threshold == pytest.approx(0.10431982925533562, rel=SAME)
    frictions = np.array([0.0, 0.99 * threshold, 1.01 * threshold])
    growth = brake_sweep.sweep(brake, frictions)
    assert growth[:2] == [0.0, 0.0]
    assert growth[2] == pytest.approx(7.0767672, rel=1e-4)
    brake_sweep.draw(frictions, growth, threshold, tmp_path / "sweep.png")
    assert (tmp_path / "sweep.png").stat().st_size > 5000


@pytest.mark.usefixtures("files_read_here")
def test_matrices_from_files():
    """2 lambda = -0.1 + sqrt(0.01 - 16 + 0.4 v i); at v = 2 the root is 0.1 + 4 i."""
    speeds = np.array([1.0, 2.0, 4.0])
    true = 0.5 * (np.sqrt(-15.99 + 0.4j * speeds).real - 0.1)
    found = matrices_from_files.growth_rates(tuple(speeds.tolist()))
    np.testing.assert_allclose(found, true, rtol=0, atol=1e-13)


def scene_file(name):
    return ROOT / "examples" / f"{name}.toml"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "backend", "digits"),
    [("hub_pad", "iga", 2), ("hub_pad", "fe", 2), ("two_pads", "iga", 3), ("two_pads", "fe", 2)],
)
def test_scenes_for_error_bars_hold_their_digits(name, backend, digits):
    """A re-entrant edge, two contacts: every mode to the digits asked for, its order named."""
    assert has_singular_edges(load_scene(scene_file(name), [], backend))
    request = Request(str(scene_file(name)), digits=digits, backends=(backend,))
    data = run_converge(request, Progress())
    assert data["held"]
    assert len(data["modes"]) >= 12
    assert all(mode["converges"] for mode in data["modes"])
    assert {mode["verdict"] for mode in data["modes"]} == {"stable"}
