"""The converged modes of disc_pad: how they are made, and what is stored."""

import numpy as np
import pytest

from cea.arrays import Floats
from comparisons.kit.progress import Progress
from comparisons.reference.study import (
    GROWTH,
    LEVELS,
    Grading,
    compute_reference,
    graded_scene,
    shared_digits,
    stored_reference,
)
from comparisons.reference.tables import reference_table

SILENT = Progress(step=lambda text: None, stage=lambda text: None)
COARSE = Grading(2, 0.02, 0.02, (0.02, 30.0, 0.012), (0.03, 20.0, 0.015))
FINER = Grading(3, 0.02, 0.02, (0.02, 30.0, 0.012), (0.03, 20.0, 0.015))


def breaks_of(scene, body, direction, backend) -> Floats:
    spec = scene.bodies[body]
    mesh = spec.mesh.fe if backend == "fe" else spec.mesh.iga
    low, high = spec.geometry.extent[spec.geometry.directions.index(direction)]
    return np.array([low, *mesh.through[direction], high])


def test_meshes_crowd_where_stress_is_large(backend):
    coarse, fine = LEVELS[backend]
    scene = graded_scene(backend, fine)
    r = breaks_of(scene, "disc", "r", backend)
    sizes = np.diff(r)
    assert sizes.max() <= 1.1 * fine.disc[0]
    if backend == "iga":
        first = fine.corner * np.expm1(fine.growth) / fine.growth  # where the sizes add up to one
        assert sizes[0] <= 1.3 * first < sizes.max()
    else:
        mesh = scene.bodies["disc"].mesh.fe
        assert (mesh.layers, len(mesh.edges)) == (fine.layers, 2)
        assert coarse.layers < fine.layers
    for boundary in (0.09, 0.14):
        assert np.abs(r - boundary).min() == 0
    theta = breaks_of(scene, "disc", "theta", backend)
    assert {25.0, 65.0} <= set(theta)
    assert coarse.degree < fine.degree


@pytest.mark.slow
def test_both_backends_are_compared_mode_by_mode():
    data = compute_reference(SILENT, {"iga": (COARSE, FINER), "fe": (COARSE, FINER)})
    assert [run["backend"] for run in data["runs"]] == ["iga", "iga", "fe", "fe"]
    finest = data["runs"][1]["modes"]
    matched = sum(mode["members"] for mode in data["modes"])
    assert matched + len(data["alone"]["fe"]) == len(data["runs"][3]["modes"])
    assert len(data["modes"]) > 10
    frequencies = np.array([mode["frequency"] for mode in finest])
    for mode in data["modes"]:
        assert np.abs(frequencies / mode["frequency"] - 1).min() < 1e-3
        assert mode["frequency_fe"] == pytest.approx(mode["frequency"], rel=0.05)
    table = reference_table(data)
    assert len(table.cells()) == len(data["modes"])


@pytest.mark.parametrize(
    ("x", "y", "digits"),
    [
        (6234.784, 6234.866, 4),
        (10.0, 10.0, 15),
        (1.0, 2.0, 0),
        (139.139, 139.088, 3),
        (5.0, 5.1, 1),
    ],
)
def test_digits_that_two_numbers_share(x, y, digits):
    assert shared_digits(x, y) == digits


def test_the_stored_reference_has_the_digits_it_promises():
    """Four common digits of frequency; of growth rates above 10 1/s, two."""
    data = stored_reference()
    assert sum(mode["members"] for mode in data["modes"]) >= 30
    assert not data["alone"]["iga"]
    assert not data["alone"]["fe"]
    for mode in data["modes"]:
        assert mode["digits_frequency"] >= 4, mode
        assert abs(mode["growth"]) <= GROWTH or mode["digits_growth"] >= 2, mode
    unstable = [mode for mode in data["modes"] if mode["growth"] > GROWTH]
    assert len(unstable) >= 6
