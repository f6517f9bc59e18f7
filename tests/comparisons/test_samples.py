"""Samples of fields that are spread: probabilities of growth, and every sample's certificate."""

import numpy as np
import pytest
from reference_data import COALESCENCES
from sweep_cases import MU, assert_within_bounds, sine_blocks

from cea.reduced.full_solves import first_threshold
from comparisons.sweep.points import read_fields
from comparisons.sweep.probabilities import growing
from comparisons.sweep.scene import mapped
from comparisons.sweep.study import Asked, run

STIFFNESS, MU_C, OMEGA = COALESCENCES[0]
CHANGES = (
    f"contacts.interface.p={STIFFNESS}",
    f"analysis.max_frequency={1.2 * OMEGA / (2 * np.pi)}",
    "analysis.growth_threshold=1e-6",  # next to the threshold growth is slow
)
"""The blocks about the first threshold that their exact solution knows."""


def asked(backend, *distributions, count=100, **options):
    spread = read_fields(distributions)
    return Asked("blocks", spread, sine_blocks(backend, *CHANGES), samples=count, **options)


def grows_in(swept):
    """Which modes of samples surely grow."""
    return growing(swept.spectra, swept.record["growth_threshold"], damped=False)[0]


@pytest.mark.grid(quick=1)
def test_the_probability_of_growth_is_that_of_passing_the_threshold(backend, tmp_path):
    """Only mu varies: what grows is what was drawn above mu_c, sample by sample.

    Both modes that coalesce are named and no other.
    """
    spread = f"mu~uniform:{0.93 * MU_C}:{1.08 * MU_C}"
    swept = run(asked(backend, spread, seed=5), tmp_path / "out")
    swept.store.discard()
    data, values, found = swept.record, swept.points.values[:, 0], grows_in(swept)
    scene = mapped("blocks", read_fields(["mu=0:1:2"]), sine_blocks(backend, *CHANGES))
    near, top = (0.9 * MU_C, 1.1 * MU_C), scene.window.max_frequency
    threshold = first_threshold(scene.driver, MU, *near, max_frequency=top).value
    scene.driver.free()
    far, grows = np.abs(values - threshold) > 1e-6 * threshold, found.any(axis=1)
    np.testing.assert_array_equal(grows[far], (values > threshold)[far])
    exact = (1.08 * MU_C - threshold) / (0.15 * MU_C)
    assert data["any"]["low"] <= exact <= data["any"]["high"]
    assert abs(data["any"]["probability"] - exact) < 4 * data["any"]["standard_error"]
    assert data["certified"] == data["values"] == 100
    assert data["not_followed"] == 0
    assert len(data["modes"]) == 2
    for mode in data["modes"]:
        assert mode["grows"] == data["any"]["grows"]
        assert mode["seen"] == 100
    assert (found[grows].sum(axis=1) == 2).all()
    growth = swept.spectra.largest[grows]
    assert data["any"]["fastest"] == pytest.approx(growth.max())
    assert data["any"]["growth"]["median"] == pytest.approx(np.median(growth))


@pytest.mark.parametrize("backend", ["iga", pytest.param("fe", marks=pytest.mark.slow)])
def test_samples_are_those_of_full_solves(backend, tmp_path):
    """Every parameter of the undamped scene is spread."""
    spread = (
        f"mu~normal:{MU_C}:{0.1 * MU_C}:0:1",
        "P~lognormal:1:0.2",
        "bodies.upper.material.E~normal:1:0.03",
        "bodies.lower.material.rho~uniform:0.9:1.1",
    )
    wanted = asked(backend, *spread, count=60, seed=1)
    swept = run(wanted, tmp_path / "out")
    swept.store.discard()
    points, grows = swept.points, grows_in(swept)
    assert swept.record["certified"] == 60
    scene = mapped("blocks", wanted.fields, wanted.overrides, samples=(60, 1))
    np.testing.assert_array_equal(scene.points.values, points.values)
    for i in (0, 17, 59):
        modes = scene.driver.solve(1.02 * scene.window.max_frequency, scene.point(points.values[i]))
        assert_within_bounds(swept, i, modes)
        inside = modes.eigenvalues.imag <= 2 * np.pi * scene.window.max_frequency
        unstable = (modes.eigenvalues.real > scene.window.growth_threshold)[inside]
        assert grows[i].any() == unstable.any()
    scene.driver.free()
