"""Sweeps that solve every value in full: what comes out at each is the result of a run there."""

import numpy as np
import pytest
from changed_scenes import scene_of

from comparisons.sweep.axes import read_axis
from comparisons.sweep.mapped import NoMapError, mapped
from comparisons.sweep.study import Sweep, run_sweep
from scenes import assemble, load_scene, run_modes
from scenes.spec.toml import scene_text

MU, PRESSURE = "contacts.interface.mu", "loads.0.pressure"


@pytest.fixture
def file_of(backend, tmp_path):
    def written(name, **changes):
        file = tmp_path / "scene.toml"
        file.write_text(scene_text(scene_of(name, backend).change(changes)))
        return file

    return written


def eigenvalues(point):
    return np.array([mode["re"] + 1j * mode["im"] for mode in point["modes"]])


def assert_runs(data, scenes):
    for point, scene in zip(data["points"], scenes, strict=True):
        np.testing.assert_allclose(eigenvalues(point), run_modes(scene).eigenvalues, rtol=1e-9)


@pytest.mark.grid
@pytest.mark.parametrize(
    ("name", "field", "values"),
    [
        ("pressed", PRESSURE, (5e-3, 3e-2)),
        ("pressed", MU, (0.1, 0.3)),
        ("pressed", "bodies.upper.material.rho", (1.0, 2.0)),
        ("rotating_pressed", "bodies.inner.rotation.rate", (0.1, 0.3)),
        ("rotating", "bodies.inner.damping.alpha", (0.0, 0.1)),
    ],
)
def test_values_are_those_of_runs(file_of, name, field, values):
    file = file_of(name)
    data = run_sweep(Sweep(file, field, *values, 2))
    assert_runs(data, [load_scene(file).change(field, value) for value in values])


@pytest.mark.parametrize("field", [MU, "mu"])
def test_parameters_of_expressions_are_factors_as_in_maps(file_of, field):
    wave = "0.2 + 0.3*x"
    file = file_of("linear", **{MU: wave})
    data = run_sweep(Sweep(file, field, 0.5, 2.0, 2))
    scenes = [load_scene(file).change(MU, f"{factor}*({wave})") for factor in (0.5, 2.0)]
    assert_runs(data, scenes)
    asked = mapped(file, [read_axis(f"{field}=0.5:2:2")], (), None)
    for point in data["points"]:
        modes = asked.driver.solve(asked.max_frequency, {MU: point["value"]})
        np.testing.assert_allclose(eigenvalues(point), modes.eigenvalues, rtol=1e-9)
    asked.driver.free()


@pytest.mark.parametrize(
    ("name", "axis"),
    [
        ("pressed", f"{PRESSURE}=1e-3:1e-2:2"),
        ("pressed", f"{MU}=0:0.3:2"),
        ("pressed", "E=1:2:2"),
        ("rotating_pressed", "bodies.inner.rotation.rate=0:0.2:2"),
        ("rotating_pressed", "bodies.inner.material.rho=1:2:2"),
    ],
)
def test_what_moves_the_state_of_sliding_has_no_map(file_of, name, axis):
    with pytest.raises(NoMapError):
        mapped(file_of(name), [read_axis(axis)], (), None)


def test_what_moves_no_state_has_one(file_of):
    asked = mapped(file_of("pressed"), [read_axis("rho=1:2:2")], (), None)
    values = dict.fromkeys(asked.names[0], 2.0)
    scene = scene_of("pressed", asked.scene["bodies"]["upper"]["backend"]).change(values)
    modes = asked.driver.solve(asked.max_frequency, values)
    np.testing.assert_allclose(modes.eigenvalues, run_modes(scene).eigenvalues, rtol=1e-9)
    asked.driver.free()


@pytest.mark.parametrize("axis", ["P=0.1:1e9:log:3", "bodies.upper.material.E=1e-9:1:log:3"])
def test_maps_take_forms_that_are_good_all_over(file_of, axis):
    asked = mapped(file_of("linear"), [read_axis(axis)], (), None)
    assert asked.driver.pencil.forces
    asked.driver.free()
    asked = mapped(file_of("linear"), [read_axis("P=0.1:10:log:3")], (), None)
    assert not asked.driver.pencil.forces
    asked.driver.free()


def test_a_field_may_be_given_by_the_sweep_alone(file_of):
    file = file_of("linear")
    whole = load_scene(file)
    file.write_text(file.read_text().replace("P = 3.0\n", ""))
    assert "\nP = " not in file.read_text()
    data = run_sweep(Sweep(file, "contacts.interface.P", 2.0, 4.0, 2))
    assert_runs(data, [whole.change("contacts.interface.P", value) for value in (2.0, 4.0)])


@pytest.mark.slow
def test_a_crowned_pad_is_pressed_by_each_load():
    """Ten times the load has ten times the normal force, and other unstable modes."""
    data = run_sweep(Sweep("crowned_pad", PRESSURE, 3e5, 3e6, 2))
    found = [eigenvalues(point) for point in data["points"]]
    assert [len(values) for values in found] == [25, 22]
    growth = [values.real.max() for values in found]
    assert growth == pytest.approx([87.113, 176.199], abs=1e-3)
    assembled = assemble(load_scene("crowned_pad"))
    steady = [assembled.modes({PRESSURE: load}).steady for load in (3e5, 3e6)]
    forces = [state.contacts["pad_disc"].normal_force for state in steady]
    assert forces == pytest.approx([1204.50, 12045.0], rel=1e-5)
