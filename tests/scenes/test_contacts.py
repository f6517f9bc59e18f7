"""Small scenes with contacts, loads and fields: what must hold on both backends."""

import numpy as np
import pytest
from blocks import FORMULATIONS, coarse, rectangle, two_blocks
from covering import covering

from cea.errors import InputError
from cea.timing import StageTimer
from scenes import load_scene, read_scene, run_modes, run_scene
from scenes.building.build import build_bodies, build_contacts, build_system


def system_of(scene):
    """The system of a scene, before steady sliding is sought."""
    timer = StageTimer()
    bodies = build_bodies(scene, timer)
    return build_system(scene, bodies, build_contacts(scene, bodies, timer), timer)


@pytest.mark.parametrize(
    ("backend", "form"), covering(("fe", "iga"), ("penalty", "saddle"), strength=1)
)
def test_a_run_repeats_itself_to_the_last_bit(backend, form):
    """On one rank."""
    gpts = {"method": "gpts", "points": 3}
    data = coarse(two_blocks(backend, gpts, held=True, form=form))
    scene = read_scene(data).change("analysis.max_frequency", 0.7)
    first, second = (run_modes(scene).modes for _ in range(2))
    assert len(first) > 5
    for name in ("eigenvalues", "growth_uncertainties", "conditions"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()


def test_rounding_where_friction_vanishes_is_not_negative_friction(backend):
    """At x = 2 the sine is -2e-16."""
    method = {"fe": "node_to_surface", "iga": "greville"}[backend]
    changes = {"mu": "0.3*sin(pi*x/2)", "formulation": {"method": method}}
    changes = {f"contacts.interface.{name}": value for name, value in changes.items()}
    system = system_of(load_scene("blocks_3d", backend=backend).change(changes))
    mu, x = system.contacts[0].friction.mu, system.contacts[0].interface.points.x[:, 0]
    assert x.max() == pytest.approx(2)
    assert mu == pytest.approx(0.3 * np.sin(np.pi * x / 2), abs=1e-15)
    assert mu.min() == 0


def test_a_direction_by_expressions_is_the_circumferential_one():
    few = {"disc": [4, 16, 1], "pad": [2, 3, 1]}
    changes, both = {f"bodies.{name}.mesh.fe.elements": n for name, n in few.items()}, []
    for direction in ({"circumferential_about": [0.0, 0.0, 1.0]}, {"field": ["-y", "x", "0"]}):
        changes["contacts.pad_disc.friction_direction_on_a"] = direction
        system = system_of(load_scene("disc_pad", backend="fe").change(changes))
        points = system.contacts[0].interface.points
        both.append(system.contacts[0].friction.along(points.x, points.normal))
    assert both[1] == pytest.approx(both[0], abs=1e-14)
    assert np.ptp(both[0][:, 0]) > 0.3


def test_a_direction_normal_to_a_side_is_refused_as_it_was_given(backend):
    scene = load_scene("blocks", ["contacts.interface.mu=0.3"], backend)
    with pytest.raises(InputError) as told:
        run_modes(scene.change("contacts.interface.friction_direction_on_a", {"vector": [0, 3.0]}))
    assert told.value.field == "contacts.interface.friction_direction_on_a"
    assert told.value.value == [0.0, 3.0]


def layer(backend, low, fixed):
    """One of two layers that mirror each other in y = 0."""
    sides = [{"surface": name, "components": ["x"]} for name in ("x_min", "x_max")]
    soft = {"E": 0.1, "nu": 0.25, "rho": 0.35}
    body = rectangle(backend, [2.0, 0.5], [6, 2], origin=[0.0, low], material=soft)
    body["mesh"]["iga"] = {"degree": [3, 3], "elements": [8, 2]}
    return body | {"supports": [{"surface": fixed}, *sides]}


@pytest.mark.parametrize(
    ("full_pass", "backend", "formulation"),
    covering((False, True), ("fe", "iga"), FORMULATIONS, strength=1),
    indirect=["formulation"],
)
def test_layers_that_mirror_each_other_do_not_flutter(backend, formulation, full_pass):
    """Even modes load the contact, odd ones slide: friction couples them one way only.

    The spectrum is that without friction, though the matrices are not symmetric: what grows there
    is rounding, and the results say so.
    """
    contact = {"a": "upper.y_min", "b": "lower.y_max", "formulation": formulation, "p": 1.0}
    contact |= {"friction_direction_on_a": {"vector": [1.0, 0.0]}, "full_pass": full_pass}
    modes, without = (
        run_scene(
            read_scene(
                {
                    "name": "mirrored layers",
                    "bodies": {
                        "upper": layer(backend, 0.0, "y_max"),
                        "lower": layer(backend, -0.5, "y_min"),
                    },
                    "contacts": {"interface": contact | {"mu": mu}},
                    "analysis": {"kind": "cea", "max_frequency": 0.6},
                }
            )
        ).modes
        for mu in ("0.9*sin(pi*x/2)", 0.0)
    )
    assert len(modes.eigenvalues) > 15
    assert not modes.unstable(0.0).any()
    assert np.all(np.abs(modes.growth_rates) <= modes.growth_uncertainties)
    assert modes.eigenvalues.imag == pytest.approx(without.eigenvalues.imag, rel=1e-6)
