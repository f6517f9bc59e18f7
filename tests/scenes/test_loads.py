"""Loads of scenes: pressures and forces on surfaces, forces on every part of a body."""

import numpy as np
import pytest
from blocks import ROTATED, block
from motions import resultant

from cea.timing import StageTimer
from scenes import read_scene
from scenes.building.build import build_bodies, build_system

SIZE, FORCE = [0.5, 0.6, 0.3], [0.3, -0.7, 1.1]


def loaded(backend, load, *, placement=None):
    """System of one free block under a load."""
    data = {
        "name": "loaded",
        "bodies": {"part": block(backend, SIZE, [0.0, 0.0, 0.0], [3, 2, 1], placement=placement)},
        "loads": [load],
        "analysis": {"kind": "static"},
    }
    scene, timer = read_scene(data), StageTimer()
    return build_system(scene, build_bodies(scene, timer), {}, timer)


@pytest.mark.parametrize("placement", [None, ROTATED])
def test_a_force_on_a_surface_is_the_sum_of_its_nodal_forces(backend, placement):
    system = loaded(backend, {"surface": "part.x_max", "force": FORCE}, placement=placement)
    assert resultant(system, system.load, "part")[0] == pytest.approx(FORCE, rel=1e-12)


def test_a_force_on_every_part_is_its_volume_times_it(backend):
    system = loaded(backend, {"body": "part", "body_force": FORCE})
    expected = np.prod(SIZE) * np.array(FORCE)
    assert resultant(system, system.load, "part")[0] == pytest.approx(expected, rel=1e-12)
