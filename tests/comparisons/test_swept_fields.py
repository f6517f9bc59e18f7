"""Fields that are swept, by their names in a scene: on a basis and in full."""

import re

import numpy as np
import pytest
from changed_scenes import scene_of
from sweep_cases import MU, P, eigenvalues, sweep_of

from cea.errors import ConvergenceError, InputError
from comparisons.sweep.page import values
from comparisons.sweep.points import read_axis
from comparisons.sweep.scene import NoMapError, mapped
from scenes import load_scene, run_modes
from scenes.running.assembled import AssembledScene, parameters_meant
from scenes.spec.plain import scene_text

PRESSURE = "loads.0.pressure"
MESHES = tuple(
    f"bodies.{body}.mesh.{mesh}.elements={elements}"
    for mesh in ("fe", "iga")
    for body, elements in (("upper", [3, 2]), ("lower", [4, 2]))
)
BLOCKS = "blocks_constant_mu"
"""Plane blocks with constant friction: p is 1 in it."""


def of(axis, *overrides):
    return mapped(BLOCKS, [read_axis(axis)], [*MESHES, *overrides])


@pytest.mark.parametrize("name", ["p", "contacts.*.p"])
def test_p_scales_the_stiffness_of_a_contact(name):
    """Modes are those of a run of the changed scene."""
    scene = of(f"{name}=0.5:2:3")
    run = run_modes(load_scene(BLOCKS, [*MESHES, "contacts.interface.p=1.7"]))
    modes = scene.driver.solve(scene.window.max_frequency, scene.point((1.7,)))
    np.testing.assert_allclose(modes.eigenvalues, run.eigenvalues, rtol=1e-9)
    own = scene.pencil.parameters[P].value
    assert scene.point((0.5,)) == {P: pytest.approx(0.5 * own)}
    scene.driver.free()


def in_full(file, field, low, high, *overrides, count=2, full=True):
    """A sweep that is solved in full, as it was asked for or as there is no map."""
    swept = sweep_of(file, [f"{field}={low}:{high}:{count}"], "unused", overrides, full=full)
    assert swept.store is None
    return swept


def assert_runs(swept, scenes):
    for i, scene in enumerate(scenes):
        np.testing.assert_allclose(eigenvalues(swept, i), run_modes(scene).eigenvalues, rtol=1e-9)


@pytest.mark.parametrize("name", ["p", "contacts.interface.p"])
def test_p_that_is_no_number_in_the_scene_is_refused(name):
    """It is no reason to solve each value in full: that would put a number in its place."""
    p, told = "contacts.interface.p='1 + 0.5*x'", "or contacts.interface.P"
    with pytest.raises(InputError, match=told) as refused:
        of(f"{name}=0.5:2:3", p)
    assert not isinstance(refused.value, NoMapError)
    with pytest.raises(InputError, match=told):
        in_full(BLOCKS, name, 0.5, 2.0, *MESHES, p)


@pytest.mark.parametrize(
    "name", ["bodies.upper.mesh.fe.degree", "bodies.upper.material.Ee", "nonsense"]
)
def test_what_is_no_parameter_is_refused_beside_all_that_are(name):
    with pytest.raises(NoMapError, match="--full solves each value in full") as refused:
        of(f"{name}=1:2:3")
    assert {P, MU, "bodies.upper.material.E"} <= set(re.findall(r"[\w.]+\w", str(refused.value)))


def test_short_names_mean_every_contact_and_body():
    scene = mapped("blocks", [read_axis("E=1:2:3"), read_axis("P=1:2:3")])
    both = ("bodies.upper.material.E", "bodies.lower.material.E")
    assert scene.names == (dict.fromkeys(both, 1.0), {P: 1.0})
    assert parameters_meant(scene.pencil, "bodies.*.material.rho") == [
        "bodies.upper.material.rho",
        "bodies.lower.material.rho",
    ]
    assert scene.point((1.5, 7.0)) == dict.fromkeys(scene.names[0], 1.5) | {P: 7.0}
    scene.driver.free()


@pytest.fixture
def file_of(backend, tmp_path):
    def written(name, **changes):
        file = tmp_path / "scene.toml"
        file.write_text(scene_text(scene_of(name, backend).change(changes)))
        return file

    return written


@pytest.mark.grid
@pytest.mark.parametrize(
    ("name", "field", "values"),
    [
        ("pressed", PRESSURE, (5e-3, 3e-2)),
        pytest.param("pressed", MU, (0.1, 0.3), marks=pytest.mark.slow),
        ("rotating_pressed", "bodies.inner.rotation.rate", (0.1, 0.3)),
        pytest.param(
            *("rotating_pressed", "bodies.inner.material.rho", (1.0, 2.0)), marks=pytest.mark.slow
        ),
        ("rotating", "bodies.inner.damping.alpha", (0.0, 0.1)),
    ],
)
def test_values_in_full_are_those_of_runs(file_of, name, field, values):
    """What moves the state of sliding has no map."""
    file = file_of(name)
    swept = in_full(file, field, *values, full="pressed" not in name)
    assert_runs(swept, [load_scene(file).change(field, value) for value in values])


@pytest.mark.grid
@pytest.mark.parametrize("field", [MU, "mu"])
def test_parameters_of_expressions_are_factors_as_in_maps(file_of, field):
    wave = "0.2 + 0.3*x"
    file = file_of("linear", **{MU: wave})
    swept = in_full(file, field, 0.5, 2.0)
    assert_runs(swept, [load_scene(file).change(MU, f"{f}*({wave})") for f in (0.5, 2.0)])
    asked = mapped(file, [read_axis(f"{field}=0.5:2:2")])
    for i, value in enumerate((0.5, 2.0)):
        modes = asked.driver.solve(asked.window.max_frequency, {MU: value})
        np.testing.assert_allclose(eigenvalues(swept, i), modes.eigenvalues, rtol=1e-9)
    asked.driver.free()


def test_thresholds_in_full_lie_between_values(monkeypatch):
    """And a value without an answer is told."""
    changes = (*MESHES, "analysis.max_frequency=0.5")
    own, dead = AssembledScene.modes_at, 1.2

    def failing(assembled, values):
        if values[MU] == pytest.approx(dead):
            raise ConvergenceError("no more digits")
        return own(assembled, values)

    monkeypatch.setattr(AssembledScene, "modes_at", failing)
    swept = in_full(BLOCKS, "mu", 0.0, 2.0, *changes, count=6)
    assert values(swept)["no_answer"].tolist() == [*[""] * 3, "no more digits", "", ""]
    told = swept.record["thresholds"]
    assert told
    monkeypatch.undo()
    exact = sweep_of(BLOCKS, ["mu=0:2:6"], "unused", changes)
    for each in exact.record["thresholds"]:
        assert any(abs(each["value"] - t["value"]) <= t["error"] for t in told)
    assert "no-answer" in [each["kind"] for each in swept.record["warnings"]]


@pytest.mark.slow
def test_a_field_without_a_map_is_solved_in_full(cea):
    axis = "bodies.upper.material.nu=0.2:0.3:2"
    coarse = [word for each in MESHES for word in ("--set", each)]
    code, told, fault = cea("sweep", BLOCKS, axis, *coarse)
    assert not code, fault
    assert "Solved in full at each value: parameter = 'bodies.upper.material.nu'" in told
