"""Scenes whose contacts obey normal compliance: equilibrium first, then modes about it."""

import pytest
from pressed import pressed_blocks

from scenes import read_scene, run_scene

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
