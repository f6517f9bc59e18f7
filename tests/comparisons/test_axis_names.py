"""Axes by the names that fields have in a scene: which parameters they mean, what is refused."""

import numpy as np
import pytest

from cea.errors import InputError
from comparisons.sweep.axes import read_axis
from comparisons.sweep.mapped import NoMapError, mapped
from comparisons.sweep.study import Sweep, run_sweep
from scenes import load_scene, run_modes

P = "contacts.interface.P"
MESHES = tuple(
    f"bodies.{body}.mesh.{mesh}.elements={elements}"
    for mesh in ("fe", "iga")
    for body, elements in (("upper", [3, 2]), ("lower", [4, 2]))
)
SANDWICH = """
name = "sandwich"
[bodies.upper]
backend = "fe"
geometry = { shape = "rectangle", size = [2.0, 0.5] }
material = { E = 0.1, nu = 0.25, rho = 0.35 }
supports = [{ surface = "y_max" }]
mesh.fe = { cell = "quadrilateral", degree = 2, elements = [3, 1] }
[bodies.lower]
backend = "fe"
geometry = { shape = "rectangle", size = [1.0, 1.0], origin = [0.5, -1.0] }
material = { E = 1.0, nu = 0.3, rho = 1.0 }
mesh.fe = { cell = "quadrilateral", degree = 2, elements = [2, 2] }
[bodies.base]
backend = "fe"
geometry = { shape = "rectangle", size = [3.0, 0.4], origin = [0.0, -1.4] }
material = { E = 0.5, nu = 0.3, rho = 0.7 }
supports = [{ surface = "y_min" }, { surface = "x_min" }]
mesh.fe = { cell = "quadrilateral", degree = 2, elements = [5, 1] }
[contacts.top]
a = "lower.y_max"
b = "upper.y_min"
formulation = { method = "gpts", points = 3 }
p = 1.0
mu = 0.3
friction_direction_on_a = { vector = [1.0, 0.0] }
[contacts.bottom]
a = "lower.y_min"
b = "base.y_max"
formulation = { method = "gpts", points = 3 }
p = 2.5
mu = 0.4
friction_direction_on_a = { vector = [1.0, 0.0] }
[analysis]
kind = "cea"
max_frequency = 0.4
"""


def blocks(*overrides):
    """The scene of plane blocks with constant friction, coarse: p is 1 in it."""
    return "blocks_constant_mu", [*MESHES, *overrides]


def of(axis, *overrides):
    scene, changes = blocks(*overrides)
    return mapped(scene, [read_axis(axis)], changes, None)


@pytest.mark.parametrize("name", ["p", "contacts.interface.p", "contacts.*.p"])
def test_p_scales_the_stiffness_of_a_contact(name):
    """Modes are those of a run of the changed scene."""
    scene = of(f"{name}=0.5:2:3")
    run = run_modes(load_scene(blocks()[0], [*MESHES, "contacts.interface.p=1.7"]))
    modes = scene.driver.solve(scene.max_frequency, scene.point((1.7,)))
    np.testing.assert_allclose(modes.eigenvalues, run.eigenvalues, rtol=1e-9)
    own = scene.pencil.parameters[P].value
    assert scene.box == {P: (pytest.approx(0.5 * own), pytest.approx(2 * own))}
    scene.driver.free()


def test_p_of_several_contacts_is_that_of_each(tmp_path):
    file = tmp_path / "sandwich.toml"
    file.write_text(SANDWICH)
    scene = mapped(file, [read_axis("p=0.5:2:3")], (), None)
    both = {f"contacts.{name}.p": 1.3 for name in ("top", "bottom")}
    run = run_modes(load_scene(file).change(both))
    modes = scene.driver.solve(scene.max_frequency, scene.point((1.3,)))
    np.testing.assert_allclose(modes.eigenvalues**2, run.eigenvalues**2, rtol=1e-8, atol=1e-12)
    scene.driver.free()


def test_derivatives_are_those_in_p():
    from cea.reduced.greedy import Enrichment
    from cea.reduced.model import ReducedModel

    scene = of("p=0.5:2:3")
    model = ReducedModel(scene.pencil, scene.box, scene.max_frequency)
    built = Enrichment(model, scene.driver, scene.max_frequency)
    built.cover([scene.point((p,)) for p in (0.5, 1.0, 2.0)])
    values = scene.pencil.values(scene.point((1.2,)))
    found = model.small.at(values)
    slopes = model.small.derivatives(found, values, scene.names[0])
    before, after = (
        model.small.at(scene.pencil.values(scene.point((1.2 + step,)))) for step in (-1e-4, 1e-4)
    )
    differences = (after.eigenvalues - before.eigenvalues) / 2e-4
    np.testing.assert_allclose(slopes, differences, rtol=1e-5, atol=1e-6)
    scene.driver.free()


def test_p_in_full_is_that_of_runs():
    scene, changes = blocks()
    data = run_sweep(Sweep(scene, "p", 0.6, 1.2, 2, tuple(changes)))
    for point, p in zip(data["points"], (0.6, 1.2), strict=True):
        run = run_modes(load_scene(scene, [*changes, f"contacts.interface.p={p}"]))
        found = [mode["re"] + 1j * mode["im"] for mode in point["modes"]]
        np.testing.assert_allclose(found, run.eigenvalues, rtol=1e-9)


@pytest.mark.parametrize("name", ["p", "contacts.top.p"])
@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("p = '1 + 0.5*x'", "contacts.top.P scales the field"),
        ("P = 3.0", "which gives contacts.top.P"),
    ],
)
def test_p_that_is_no_number_in_the_scene_is_refused(tmp_path, name, given, told):
    """It is no reason to solve each value in full: that would put a number in its place."""
    file = tmp_path / "sandwich.toml"
    file.write_text(SANDWICH.replace("p = 1.0", given))
    with pytest.raises(InputError, match=told) as refused:
        mapped(file, [read_axis(f"{name}=0.5:2:3")], (), None)
    assert not isinstance(refused.value, NoMapError)
    with pytest.raises(InputError, match=told):
        run_sweep(Sweep(file, name, 0.5, 2.0, 3))


def test_p_and_P_are_one_axis():
    scene, changes = blocks()
    axes = [read_axis("p=0.5:2:3"), read_axis("P=1:2:3")]
    with pytest.raises(InputError, match="other parameters"):
        mapped(scene, axes, changes, None)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("bodies.upper.material.nu", "--full"),
        ("nonsense", "one of bodies"),
    ],
)
def test_what_is_no_parameter_says_what_to_do(name, told):
    with pytest.raises(NoMapError, match=told) as refused:
        of(f"{name}=1:2:3")
    assert P in str(refused.value)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ("bodies.upper.damping={alpha=0.0}", "alpha"),
        ("bodies.upper.damping={beta=0.0}", "beta"),
        ("contacts.interface.mu=0.0", "mu"),
    ],
)
def test_what_is_told_to_do_makes_it_a_parameter(change, name):
    scene = of(f"{name}=0:0.1:2", change)
    assert scene.names[0]
    scene.driver.free()
