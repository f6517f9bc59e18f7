"""Gaps of curved contacts are those of the shapes, however coarse the facets.

Truths are Lame's rings in closed form, distances between circles, and NURBS, whose surfaces are
those of the shapes.
"""

import numpy as np
import pytest
from curved_scenes import (
    MORTAR,
    SEGMENTS,
    in_files,
    kinds,
    lame,
    normal_force,
    pressed,
    rings,
    shaft,
)

from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_interfaces
from scenes.spec.reading import read_scene

PLACED = {"axis": [0.0, 0.0, 1.0], "angle": 37.0, "translation": [0.3, -0.2, 0.0]}


def interface(data):
    scene = read_scene(data)
    (found,) = build_interfaces(scene, build_bodies(scene, StageTimer()), StageTimer()).values()
    return found


@pytest.mark.parametrize(
    ("degree", "backends"),
    [(1, ("fe", "fe")), (2, ("fe", "iga")), (3, ("iga", "fe")), (4, ("fe", "fe"))],
)
def test_rings_that_touch_have_no_gap(degree, backends):
    data = rings(degree, ((1, 24), (1, 16)), backends)
    for each in data["bodies"].values():
        each["placement"] = PLACED
    found = interface(data)
    assert np.abs(found.initial_gap).max() < 1e-15
    assert found.largest_distance > {1: 3e-4, 2: 3e-7, 3: 1e-8, 4: 3e-11}[degree]


@pytest.mark.parametrize("degree", [1, 3])
def test_a_shaft_keeps_its_clearance(degree):
    """The distance of two circles along the lines on which facets are searched."""
    clearance = 2e-5
    found = interface(shaft("fe", degree, 1, clearance))
    x, n = found.points.x, found.points.normal
    across = np.einsum("ij,ij->i", x, n)
    beyond = (x**2).sum(axis=1) - across**2
    ends = [np.sqrt(radius**2 - beyond) for radius in (0.07 - clearance, 0.07)]
    np.testing.assert_allclose(found.initial_gap, ends[1] - ends[0], rtol=0, atol=1e-15)
    assert found.initial_gap.min() == pytest.approx(clearance, rel=1e-5)


@pytest.mark.parametrize(
    ("degree", "elements", "formulation"),
    [
        (1, ((2, 80), (2, 68)), MORTAR),
        (2, ((2, 20), (2, 16)), SEGMENTS),
        (3, ((2, 20), (2, 16)), MORTAR),
    ],
)
def test_rings_meet_the_pressure_of_lame(degree, elements, formulation):
    """The normal force always; the peak to two per cent, or with a warning."""
    result, state = pressed(rings(degree, elements, formulation=formulation))
    assert state.normal_force == pytest.approx(normal_force(lame()), rel=2e-3)
    if abs(state.pressure.max() / lame() - 1) > 0.02:
        assert kinds(result)["geometry-error"]["relative"] > 0.01
    else:
        assert result.warnings == ()
        assert state.closed_fraction == 1
    assert result.warnings == () or formulation is SEGMENTS


@pytest.mark.parametrize("degree", [1, 2])
def test_gaps_that_a_mesh_file_cannot_tell_count_as_zero(degree, tmp_path):
    """Rings touch; their normal force is right, and it is said that nobody knows that they do."""
    data = in_files(rings(degree, ((2, 24), (2, 16))), tmp_path)
    result, state = pressed(data)
    assert state.normal_force == pytest.approx(normal_force(lame()), rel=5e-3)
    assert state.pressure.max() == pytest.approx(lame(), rel=0.02)
    found = kinds(result)
    assert found["gaps-as-zero"]["fraction"] == pytest.approx(1)
    assert 0 < found["gaps-as-zero"]["gap"] < found["gaps-as-zero"]["geometry_error"]
    closure = found["geometry-error"]["closure"]
    assert closure == pytest.approx(lame() / 1e12, rel=0.02)
    assert found["geometry-error"]["geometry_error"] > closure


def test_a_clearance_below_the_error_of_a_mesh_file_is_told(tmp_path):
    result, _ = pressed(in_files(shaft("fe", 1, 1), tmp_path))
    found = kinds(result)
    assert found["gaps-as-zero"]["geometry_error"] > 2e-5
    assert found["geometry-error"]["relative"] > 1
