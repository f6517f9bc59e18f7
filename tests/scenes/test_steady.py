"""Steady sliding of scenes: loads in steps, open points, lost equilibria, thresholds about it."""

from functools import cache

import numpy as np
import pytest
import pyvista
from blocks import GPTS, coarse
from pressed import AREA, PRESSURE, pressed_blocks

from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError, InputError
from cea.system.steady_equations import SteadyEquations, free_tangent
from cea.system.steady_path import Iteration, SteadyNewton
from cea.system.steady_state import LoadStep, uniqueness_at
from cea.timing import StageTimer
from comparisons.stability.scenes import sprag
from scenes import assemble, read_scene, run_modes, run_scene
from scenes.building.build import build_bodies, build_contacts, build_system
from scenes.export.paraview import write_paraview

LAW = {"c_n": 1e2, "m_n": 2.0, "mu": 0.3, "added_gap": "0.2*(x-0.45)**2"}
MU = "contacts.interface.mu"
STEPS = [0.1, 0.4, 1.0]


@cache
def stepped(backend, *steps):
    """A static run with loads put on in steps; at once without any."""
    data = pressed_blocks(backend, GPTS, kind="static", **LAW)
    if steps:
        data["analysis"]["load_steps"] = steps[0] if len(steps) == 1 else list(steps)
    return run_scene(read_scene(data))


def test_the_history_is_kept(backend):
    """Each step bears its part of the load, and more of the contact is closed from step to step."""
    path = stepped(backend, *STEPS).steady.path
    assert [step.factor for step in path] == STEPS
    states = [step.contacts["interface"] for step in path]
    forces = [state.normal_force for state in states]
    assert forces == pytest.approx([PRESSURE * AREA * f for f in STEPS], rel=1e-10)
    closed = [state.closed_fraction for state in states]
    assert closed == sorted(closed)
    assert closed[0] < closed[-1] <= 1
    at_once = stepped(backend).steady
    pressure = at_once.contacts["interface"].pressure
    assert states[-1].pressure == pytest.approx(pressure, abs=1e-9 * pressure.max())
    assert at_once.path[-1].displacement is None


def test_every_step_is_a_time_in_paraview(backend, tmp_path):
    result = stepped(backend, *STEPS)
    *_, file = write_paraview(result, 1, tmp_path)
    reader = pyvista.get_reader(file)
    assert reader.time_values == STEPS
    for step in result.steady.path:
        reader.set_active_time_value(step.factor)
        upper, _, contact = reader.read()
        state = step.contacts["interface"]
        assert contact["contact pressure"] == pytest.approx(state.pressure)
        u = result.system.displacement(step.displacement, "upper")
        assert np.abs(upper["displacement"]).max() == pytest.approx(np.abs(u).max(), rel=0.3)


def test_halves_of_a_full_pass_are_told_as_such(backend):
    """They share the force: the line of either is no statement about the contact."""
    law = {"c_n": 1e3, "m_n": 1.0, "mu": 0.0, "full_pass": True}
    result = run_scene(read_scene(pressed_blocks(backend, GPTS, kind="static", **law)))
    forces = [state.normal_force for state in result.steady.contacts.values()]
    assert sum(forces) == pytest.approx(PRESSURE * AREA, rel=1e-9)
    assert len(forces) == 2
    assert all("half of a full pass of interface" in line for line in result.steady_lines())


@pytest.fixture
def refuse(monkeypatch):
    """Lets Newton's method fail at parts of the load."""
    whole = SteadyNewton.solve

    def fail_where(refused):
        def solve(self, x, f, factor):
            if refused(factor):
                return Iteration(LoadStep(factor), self._equations.state(x, f, factor))
            return whole(self, x, f, factor)

        monkeypatch.setattr(SteadyNewton, "solve", solve)

    return fail_where


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_steps_are_cut_where_no_equilibrium_is_found(backend, refuse):
    """As if Newton's method failed wherever the load grows by a tenth of the whole or more."""
    found = [0.0]

    def too_far(factor):
        if factor < found[-1] + 0.1:
            found.append(factor)
            return False
        return True

    refuse(too_far)
    factors = [step.factor for step in stepped(backend, 0.05, 0.5, 1.0).steady.path]
    assert {0.05, 0.5, 1.0} <= set(factors)
    assert factors == found[1:]
    assert len(factors) > 9


def test_open_points_stay_points(backend):
    result = run_modes(read_scene(pressed_blocks(backend, GPTS, **LAW | {"mu": 0.0})))
    (contact,) = result.system.contacts
    state = result.steady.contacts["interface"]
    assert 0 < state.closed_fraction < 1
    assert len(contact.slope) == len(contact.interface.points)
    assert contact.slope == pytest.approx(state.stiffness)
    assert (contact.slope[state.closure <= 0] == 0).all()
    assert contact.law.pressure(contact.closure) == pytest.approx(state.pressure)


# A block whose back slides on a plane at 60 degrees to the contact. Balance gives
# N = F / (1 - mu tan 60), and the tangent is singular where friction is cot 60.
FORCE, LIMIT = 1e-3, 1 / np.tan(np.radians(60.0))


def pressed_sprag(backend, mu):
    data = sprag(mu=mu, c_n=1.0, m_n=2.0, formulation=GPTS)
    for body in data["bodies"].values():
        body["backend"] = backend
    loads = [{"surface": "block.y_max", "pressure": FORCE}]
    return read_scene(data | {"loads": loads, "analysis": {"kind": "cea", "max_frequency": 0.2}})


@pytest.mark.parametrize("mu", [0.1, 0.3, 0.55])
def test_friction_multiplies_the_force_until_the_tangent_is_singular(backend, mu):
    steady = run_scene(pressed_sprag(backend, mu)).steady
    left = 1 - mu / LIMIT
    assert steady.contacts["contact"].normal_force == pytest.approx(FORCE / left, rel=1e-9)
    assert steady.uniqueness.margin == pytest.approx(left, rel=0.05)
    assert not steady.uniqueness.lost


@pytest.mark.parametrize(("factor", "lost"), [(0.9, False), (1.1, True)])
def test_beyond_the_limit_the_determinant_has_changed_its_sign(backend, factor, lost):
    """Of the tangent where every point is closed, whether that is an equilibrium or not."""
    scene, timer = pressed_sprag(backend, factor * LIMIT), StageTimer()
    bodies = build_bodies(scene, timer)
    problem = SteadyEquations(
        build_system(scene, bodies, build_contacts(scene, bodies, timer), timer)
    )
    closed = [np.full_like(gap, 0.1) for gap in problem.gaps_at(1.0)]
    tangent = problem.tangent(problem.slopes(closed))
    found = uniqueness_at(tangent, Shifted(tangent), {1.0: None}, unstable=False)
    free_tangent(tangent)
    assert (found.parity, found.lost) == (int(lost), lost)
    assert [warning.kind for warning in found.warnings()] == ["not-unique"] * lost


@pytest.mark.grid(quick=1)
def test_beyond_the_limit_there_is_no_equilibrium(backend):
    with pytest.raises(ConvergenceError, match="no state of steady sliding") as refused:
        run_scene(pressed_sprag(backend, 1.2 * LIMIT))
    assert refused.value.best.relative > 1e-3


def test_a_threshold_with_the_state_sought_anew():
    """Scenes solved anew on either side of it flutter, or do not."""
    law = {"c_n": 1e3, "m_n": 2.0, "added_gap": "0.05*(x-0.45)**2"}
    data = coarse(pressed_blocks("iga", GPTS, mu=0.3, **law))
    data["analysis"]["max_frequency"] = 0.7
    scene = read_scene(data)
    assembled = assemble(scene)
    followed = assembled.threshold(MU, 0.2465, 0.2475)
    assert "steady-state-kept" in [w.kind for w in assembled.modes(left=True).warnings]
    with pytest.raises(InputError, match="parameter"):
        assembled.threshold("contacts.interface.size", 0.2, 0.4)

    def growth(mu):
        result = run_modes(scene.change(MU, mu))
        near = np.abs(result.frequencies / followed.frequency - 1) < 0.01
        return float(result.growth_rates[near].max())

    step = 1e-5 * followed.value
    assert growth(followed.value - step) < 1e-6
    # beside the threshold growth is the root of a linear function of mu
    above = growth(followed.value + step)
    assert above > 1e-5
    assert growth(followed.value + 4 * step) == pytest.approx(2 * above, rel=1e-2)


def test_where_cutting_does_not_help_the_part_of_the_load_is_told(backend, refuse):
    refuse(lambda factor: factor > 0.5)
    with pytest.raises(ConvergenceError, match=r"at 0\.50\d of the load"):
        stepped(backend, 4)
