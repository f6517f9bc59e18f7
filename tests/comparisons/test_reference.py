"""The converged modes of disc_pad: how they are made, and what is stored."""

import numpy as np
import pytest

from cea.arrays import Floats
from comparisons.reference.study import (
    GROWTH,
    LEVELS,
    STUDY,
    Options,
    graded_scene,
    shared_digits,
)
from comparisons.study.result import read
from comparisons.study.run import run


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


def test_both_backends_are_compared_mode_by_mode(tmp_path):
    result = run(STUDY, Options(**STUDY.quick), tmp_path / "out")
    runs, modes, found = (result.frame(name) for name in ("runs", "modes", "run_modes"))
    assert list(runs["backend"]) == ["iga", "iga", "fe", "fe"]
    sizes = found.groupby(["backend", "degree"]).size()
    alone = result.frame("alone")
    lone = 0 if alone.empty else (alone["backend"] == "fe").sum()
    assert modes["members"].sum() + lone == sizes["fe", 3]
    assert len(modes) > 10
    finest = found.query("backend == 'iga' and degree == 3")["frequency"].to_numpy()
    for mode in modes.to_dict("records"):
        assert np.abs(finest / mode["frequency"] - 1).min() < 1e-3
        assert mode["frequency_fe"] == pytest.approx(mode["frequency"], rel=0.05)


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
    result = read("reference", STUDY.shipped)
    modes = result.frame("modes")
    assert modes["members"].sum() >= 30
    assert result.frame("alone").empty
    assert (modes["digits_frequency"] >= 4).all()
    fast = modes[modes["growth"].abs() > GROWTH]
    assert (fast["digits_growth"] >= 2).all()
    assert (fast["growth"] > 0).sum() >= 6
