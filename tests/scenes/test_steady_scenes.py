"""Scenes whose contacts obey normal compliance: equilibrium first, then modes about it."""

import pytest
from pressed import SOFT, pressed_blocks

from scenes import read_scene, run_scene
from scenes.spec.problems import SceneError

GPTS = {"method": "gpts", "points": 3}


def test_open_points_stay_points(backend):
    law = {"c_n": 100.0, "m_n": 2.0, "mu": 0.0, "added_gap": "0.2*(x-0.45)**2"}
    result = run_scene(read_scene(pressed_blocks(backend, GPTS, **law)))
    (contact,) = result.system.contacts
    state = result.steady.contacts["interface"]
    assert 0 < state.closed_fraction < 1
    assert len(contact.slope) == len(contact.interface.points)
    assert contact.slope == pytest.approx(state.stiffness)
    assert (contact.slope[state.closure <= 0] == 0).all()
    assert contact.law.pressure(contact.closure) == pytest.approx(state.pressure)


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"c_n": 0.0}, "c_n"),
        ({"c_n": -1.0}, "c_n"),
        ({"c_n": float("inf")}, "c_n"),
        ({"m_n": 0.9}, "m_n"),
        ({"m_n": 25.0}, "m_n"),
        ({"p": 1.0}, "P"),
        ({"P": 1.0}, "P"),
        ({"added_gap": "no such"}, "added_gap"),
        ({"formulation": {"method": "gpts", "points": 3, "lumped": True}}, "method"),
        ({"formulation": {"method": "mortar"}, "form": "saddle"}, "form"),
        ({"c_n": None, "p": 1.0, "m_n": 2.0}, "m_n"),
        ({"c_n": None, "p": 1.0, "added_gap": 0.1}, "added_gap"),
    ],
)
def test_what_makes_no_law_is_refused(backend, changes, field):
    options = {"c_n": SOFT} | changes
    formulation = options.pop("formulation", GPTS)
    with pytest.raises(SceneError) as refused:
        read_scene(pressed_blocks(backend, formulation, **options))
    assert any(fault.field.endswith(f".{field}") for fault in refused.value.faults)
