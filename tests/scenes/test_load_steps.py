"""Loads put on in steps: the history, its files and pictures, refusals, ranks."""

from functools import cache

import numpy as np
import pytest
import pyvista
from matplotlib.image import imread
from mpi import on_ranks
from pressed import AREA, PRESSURE, pressed_blocks
from same_numbers import assert_same

from cea.errors import ConvergenceError
from cea.system.steady_newton import Iteration, SteadyNewton
from cea.system.steady_path import check_steps
from comparisons.kit.contact_pictures import draw_contacts
from scenes import assemble, open_result, read_scene, run_scene, save_result
from scenes.checking.steps import skipped_by
from scenes.export.paraview_steps import write_load_steps
from scenes.spec.plain import as_data
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

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


def colours(image):
    """Number of different colours of an image of values from 0 to 1."""
    return len(np.unique(np.rint(255 * image).astype(int) @ [65536, 256, 1]))


def refuse(monkeypatch, refused):
    """Let Newton's method fail at parts of the load."""
    whole = SteadyNewton.solve

    def solve(self, x, f, factor):
        if refused(factor):
            return Iteration(self._equations.state(x, f, factor))
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
    assert all(0 < step.state.margin <= 1.5 for step in path)
    at_once = run_scene(read_scene(pressed_blocks(backend, GPTS, kind="static", **LAW)))
    pressure = at_once.steady.contacts["interface"].pressure
    assert states[-1].pressure == pytest.approx(pressure, abs=1e-9 * pressure.max())
    assert at_once.steady.path[-1].state is None


def test_the_history_is_told_and_stored(result, tmp_path):
    data = open_result(save_result(result, tmp_path / "result.json")).data["steady_sliding"]
    for told, step in zip(data["path"], result.steady.path, strict=True):
        assert told["load"] == step.factor
        assert told["iterations"] == len(step.lengths) > 0
        assert told["margin"] == step.state.margin
        state = step.state.contacts["interface"]
        assert told["contacts"]["interface"]["closed_area"] == state.closed_area
    assert [line[:3] for line in result.steady_lines()[:3]] == ["0.1", "0.4", "1 o"]


def test_a_scene_without_steps_says_nothing_of_them(backend):
    data = pressed_blocks(backend, GPTS, kind="static", **LAW)
    assert "load_steps" not in as_data(read_scene(data))["analysis"]
    told = run_scene(read_scene(data))
    assert len(told.steady_lines()) == 1
    assert write_load_steps(told, None) == []


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


def test_prescribed_displacements_grow_with_the_steps(backend, tmp_path):
    data = pressed_blocks(backend, GPTS, kind="static", c_n=10.0, mu=0.0) | {"loads": []}
    data["bodies"]["upper"]["supports"] = [{"surface": "z_max", "value": [0.0, 0.0, -1e-3]}]
    data["analysis"]["load_steps"] = 4
    result = run_scene(read_scene(data))
    forces = [step.state.contacts["interface"].normal_force for step in result.steady.path]
    assert forces == pytest.approx([forces[-1] * part for part in (0.25, 0.5, 0.75, 1.0)])
    reader = pyvista.get_reader(write_load_steps(result, tmp_path)[0])
    for factor in reader.time_values:
        reader.set_active_time_value(factor)
        assert reader.read()[0]["displacement"][:, 2].min() == pytest.approx(-1e-3 * factor)


@pytest.mark.parametrize("backend", [pytest.param("iga", marks=pytest.mark.slow), "fe"])
def test_contacts_are_drawn(result, tmp_path):
    (file,) = draw_contacts(result, tmp_path)
    assert file.name == f"contact_{result.scene.backends}_interface.png"
    image = imread(file)[..., :3]
    assert colours(image) > 100
    state = result.steady.contacts["interface"]
    blue = np.abs(image - np.array([0, 0x72, 0xB2]) / 255).max(axis=2) < 0.02
    grey = np.abs(image - 0xD9 / 255).max(axis=2) < 0.005
    share = blue.sum() / (blue.sum() + grey.sum())
    assert share == pytest.approx(state.closed_fraction, abs=0.15)


@pytest.mark.slow
def test_contacts_in_the_plane_are_drawn_and_given_ones_are_not(tmp_path):
    found = run_scene(load_scene("hertz_cylinder"))
    (file,) = draw_contacts(found, tmp_path)
    assert colours(imread(file)[..., :3]) > 50
    given = run_scene(read_scene(pressed_blocks("fe", GPTS, kind="static", p=10.0)))
    assert draw_contacts(given, tmp_path) == []


def test_a_static_scene_may_ask_for_pictures_of_its_contacts(backend):
    data = pressed_blocks(backend, GPTS, kind="static", **LAW) | {"output": {"pictures": 1}}
    assert "pictures" not in skipped_by(read_scene(data))


@pytest.mark.parametrize(
    "steps",
    [0, -1, 1001, 2.5, [], [0.5], [0.0, 1.0], [0.5, 0.5, 1.0], [0.5, 1.5], [1.0, 0.5], "many"],
)
def test_what_are_no_steps_is_refused(backend, steps):
    with pytest.raises(SceneError) as refused:
        stepped(backend, steps)
    assert all(fault.field.startswith("analysis.load_steps") for fault in refused.value.faults)
    if isinstance(steps, list):
        with pytest.raises(ValueError, match="rise"):
            check_steps(steps, "steps")


def test_without_a_law_there_is_nothing_to_step(backend):
    data = pressed_blocks(backend, GPTS, p=10.0)
    data["analysis"]["load_steps"] = 3
    with pytest.raises(SceneError, match=r"analysis\.load_steps = 3: left out"):
        read_scene(data)


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_a_sweep_takes_steps_of_its_own(backend):
    scene = stepped(backend, 2, kind="cea")
    assembled = assemble(scene)
    assert len(assembled.modes().steady.path) == 2
    assert len(assembled.modes({"analysis.load_steps": 3}).steady.path) == 3


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("ranks", "backend"),
    [
        (2, "iga"),
        pytest.param(2, "fe", marks=pytest.mark.slow),
        pytest.param(3, "fe", marks=pytest.mark.slow),
        pytest.param(3, "iga", marks=pytest.mark.slow),
    ],
)
def test_ranks_find_the_same_history(ranks, backend):
    found, expected = (on_ranks(n, "prestress_numbers.history", backend) for n in (ranks, 1))
    assert_same(found, expected, rel=1e-8)
