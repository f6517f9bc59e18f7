"""Loads put on in steps: the history, its files and pictures, refusals, ranks."""

from functools import cache

import numpy as np
import pytest
import pyvista
from pressed import AREA, PRESSURE, pressed_blocks

from cea.errors import ConvergenceError
from cea.system.steady_newton import Iteration, SteadyNewton
from cea.system.steady_state import LoadStep
from scenes import read_scene, run_scene
from scenes.export.paraview import write_load_steps
from scenes.spec.problems import SceneError

GPTS = {"method": "gpts", "points": 3}
LAW = {"c_n": 1e2, "m_n": 2.0, "mu": 0.3, "added_gap": "0.2*(x-0.45)**2"}


def stepped(backend, steps, *, kind="static", **law):
    data = pressed_blocks(backend, GPTS, kind=kind, **(LAW | law))
    data["analysis"]["load_steps"] = steps
    return read_scene(data)


@cache
def run_on(backend):
    return run_scene(stepped(backend, [0.1, 0.4, 1.0]))


@pytest.fixture
def result(backend):
    return run_on(backend)


def refuse(monkeypatch, refused):
    """Let Newton's method fail at parts of the load."""
    whole = SteadyNewton.solve

    def solve(self, x, f, factor):
        if refused(factor):
            return Iteration(LoadStep(factor), self._equations.state(x, f, factor))
        return whole(self, x, f, factor)

    monkeypatch.setattr(SteadyNewton, "solve", solve)


def test_the_history_is_kept(backend, result):
    """Each step bears its part of the load, and more of the contact is closed from step to step."""
    path = result.steady.path
    assert [step.factor for step in path] == [0.1, 0.4, 1.0]
    states = [step.state.contacts["interface"] for step in path]
    forces = [state.normal_force for state in states]
    assert forces == pytest.approx([PRESSURE * AREA * f for f in (0.1, 0.4, 1.0)], rel=1e-10)
    closed = [state.closed_fraction for state in states]
    assert closed == sorted(closed)
    assert closed[0] < closed[-1] <= 1
    at_once = run_scene(read_scene(pressed_blocks(backend, GPTS, kind="static", **LAW)))
    pressure = at_once.steady.contacts["interface"].pressure
    assert states[-1].pressure == pytest.approx(pressure, abs=1e-9 * pressure.max())
    assert at_once.steady.path[-1].state is None


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_steps_are_cut_where_no_equilibrium_is_found(backend, monkeypatch):
    """As if Newton's method failed wherever the load grows by a tenth of the whole or more."""
    found = [0.0]

    def too_far(factor):
        if factor < found[-1] + 0.1:
            found.append(factor)
            return False
        return True

    refuse(monkeypatch, too_far)
    path = run_scene(stepped(backend, [0.05, 0.5, 1.0])).steady.path
    factors = [step.factor for step in path]
    assert {0.05, 0.5, 1.0} <= set(factors)
    assert factors == found[1:]
    assert len(factors) > 9


def test_where_cutting_does_not_help_the_part_of_the_load_is_told(backend, monkeypatch):
    refuse(monkeypatch, lambda factor: factor > 0.5)
    with pytest.raises(ConvergenceError, match=r"at 0\.50\d of the load"):
        run_scene(stepped(backend, 4))


def test_every_step_is_a_time_in_paraview(result, tmp_path):
    (file,) = write_load_steps(result, tmp_path)
    reader = pyvista.get_reader(file)
    assert reader.time_values == [0.1, 0.4, 1.0]
    for step in result.steady.path:
        reader.set_active_time_value(step.factor)
        upper, _, contact = reader.read()
        state = step.state.contacts["interface"]
        assert contact["contact pressure"] == pytest.approx(state.pressure)
        u = result.system.displacement(step.state.displacement, "upper")
        assert np.abs(upper["displacement"]).max() == pytest.approx(np.abs(u).max(), rel=0.3)


@pytest.mark.parametrize(
    "steps",
    [0, -1, 1001, 2.5, [], [0.5], [0.0, 1.0], [0.5, 0.5, 1.0], [0.5, 1.5], [1.0, 0.5], "many"],
)
def test_what_are_no_steps_is_refused(backend, steps):
    with pytest.raises(SceneError) as refused:
        stepped(backend, steps)
    assert all(fault.field.startswith("analysis.load_steps") for fault in refused.value.faults)
