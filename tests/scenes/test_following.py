"""Thresholds and derivatives of scenes whose state of steady sliding moves with a parameter."""

import numpy as np
import pytest
from pressed import pressed_blocks

from cea.errors import InputError
from cea.reduced.full_solves import ConfirmedThreshold
from scenes import assemble, load_scene, read_scene, run_modes

MU = "contacts.interface.mu"
GPTS = {"method": "gpts", "points": 3}
LAWS = {
    "fe": {"c_n": 1e4, "m_n": 2.0},
    "iga": {"c_n": 1e2, "m_n": 2.0, "added_gap": "0.05*(x-0.45)**2"},
}
"""With which a pair of modes begins to flutter between mu = 0.2 and 0.4."""


def scene_of(backend, **contact):
    data = pressed_blocks(backend, GPTS, mu=0.3, **(contact or LAWS[backend]))
    data["bodies"]["upper"]["mesh"]["fe"]["degree"] = 1
    data["analysis"]["max_frequency"] = 1.2
    return read_scene(data)


def kinds(found):
    return [warning.kind for warning in found.warnings]


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_a_threshold_follows_the_state(backend):
    """Scenes solved anew on either side of it flutter, or do not."""
    scene = scene_of(backend)
    assembled = assemble(scene)
    followed = assembled.threshold(MU, 0.2, 0.4)
    assert followed.warnings == ()
    assert "steady-state-kept" in kinds(assembled.modes(left=True))

    def growth(mu):
        result = run_modes(scene.change(MU, mu))
        near = np.abs(result.frequencies / followed.frequency - 1) < 0.01
        return float(result.growth_rates[near].max())

    step = 1e-5 * followed.value
    below, above = growth(followed.value - step), growth(followed.value + step)
    assert below < 1e-6
    # beside the threshold growth is the root of a linear function of mu
    assert above > 1e-5
    assert growth(followed.value + 4 * step) == pytest.approx(2 * above, rel=1e-2)


def test_thresholds_in_what_is_no_parameter_are_refused(backend):
    with pytest.raises(InputError, match="parameter"):
        assemble(scene_of(backend)).threshold("contacts.interface.size", 0.2, 0.4)


def test_thresholds_are_sought_with_contact_forces_as_unknowns(backend, monkeypatch):
    """However stiff a contact becomes no digits are lost."""
    scene = read_scene(pressed_blocks(backend, GPTS, P=3.0, mu=0.3))
    solved = []

    def sought(driver, names, real, flutter, **options):
        solved.append(bool(driver.pencil.forces))
        return ConfirmedThreshold(names[0], real, 1j, 0, 0)

    monkeypatch.setattr("scenes.running.assembled.first_threshold", sought)
    assemble(scene).threshold("contacts.interface.P", 1.0, 30.0)
    assert solved == [True]


def test_growth_of_a_damped_pair_passes_zero_at_its_threshold(backend):
    """The partner of the mode that begins to grow decays, near by."""
    scene = load_scene("blocks", ["bodies.upper.damping={alpha=0.002}"], backend)
    assembled = assemble(scene)
    found = assembled.threshold("mu", 0.0, 1.0)
    assert abs(found.eigenvalue.real) < 1e-9
    for part, sign in ((-1e-4, -1), (1e-4, 1)):
        growth = assembled.modes_at({MU: found.value * (1 + part)}).growth_rates.max()
        assert np.sign(growth) == sign
