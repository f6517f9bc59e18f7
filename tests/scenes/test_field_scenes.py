"""Friction and stiffness given as expressions in scenes."""

from pathlib import Path

import numpy as np
import pytest

from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_interfaces, build_system
from scenes.spec.reading import load_scene


def law_and_points(scene):
    bodies = build_bodies(scene, StageTimer())
    interfaces = build_interfaces(scene, bodies, StageTimer())
    law = build_system(scene, bodies, interfaces, StageTimer()).contacts[0]
    return law, interfaces["interface"].points.x


def blocks(backend, **fields):
    method = {"fe": "node_to_surface", "iga": "greville"}[backend]
    overrides = [f"contacts.interface.formulation={{method='{method}'}}"]
    overrides += [f"contacts.interface.{name}={value}" for name, value in fields.items()]
    return load_scene(Path("blocks_3d"), overrides, backend)


def test_rounding_where_friction_vanishes_is_not_negative_friction(backend):
    """At x = 2 the sine is -2e-16."""
    law, x = law_and_points(blocks(backend, mu="0.3*sin(pi*x/2)"))
    assert x[:, 0].max() == pytest.approx(2)
    assert law.friction.mu == pytest.approx(0.3 * np.sin(np.pi * x[:, 0] / 2), abs=1e-15)
    assert law.friction.mu.min() == 0


def test_a_direction_by_expressions_is_the_circumferential_one():
    directions = ("{circumferential_about=[0.0, 0.0, 1.0]}", '{field=["-y", "x", "0"]}')
    name = "contacts.pad_disc.friction_direction_on_a"
    coarse = ["bodies.disc.mesh.fe.elements=[4, 16, 1]", "bodies.pad.mesh.fe.elements=[2, 3, 1]"]
    both = []
    for direction in directions:
        scene = load_scene(Path("disc_pad"), [f"{name}={direction}", *coarse], "fe")
        bodies = build_bodies(scene, StageTimer())
        interfaces = build_interfaces(scene, bodies, StageTimer())
        law = build_system(scene, bodies, interfaces, StageTimer()).contacts[0]
        points = interfaces["pad_disc"].points
        both.append(law.friction.along(points.x, points.normal))
    assert both[1] == pytest.approx(both[0], abs=1e-14)
    assert np.ptp(both[0][:, 0]) > 0.3
