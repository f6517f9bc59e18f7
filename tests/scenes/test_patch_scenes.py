"""Scenes whose geometry is given as NURBS patches."""

import pytest

from scenes import run_scene
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene

HALVES = {
    "shape": "patches",
    "patches": [
        {
            "degrees": [1, 1],
            "knots": [[0, 0, 1, 1], [0, 0, 1, 1]],
            "control_points": [[[0.0, 0.0], [0.0, 0.5]], [[0.5, 0.0], [0.5, 0.5]]],
        },
        {  # the right half, its parameters swapped and one reversed
            "degrees": [1, 1],
            "knots": [[0, 0, 2, 2], [0, 0, 1, 1]],
            "control_points": [[[1.0, 0.5], [0.5, 0.5]], [[1.0, 0.0], [0.5, 0.0]]],
        },
    ],
    "faces": {"y_min": [[0, 1, 0], [1, 0, 1]], "right": [[1, 1, 0]]},
}


def scene(geometry, elements):
    body = {
        "backend": "iga",
        "geometry": geometry,
        "material": {"E": 1.0, "nu": 0.3, "rho": 1.0},
        "supports": [{"surface": "y_min"}],
        "mesh": {"iga": {"degree": [2, 2], "elements": elements}},
    }
    return {
        "name": "plate",
        "bodies": {"plate": body},
        "analysis": {"kind": "cea", "max_frequency": 1.5},
    }


def test_given_patches_are_the_shape_they_describe():
    whole = {"shape": "rectangle", "size": [1.0, 0.5]}
    given = run_scene(read_scene(scene(HALVES, [6, 6]))).modes.frequencies
    built = run_scene(read_scene(scene(whole, [12, 6]))).modes.frequencies
    assert len(given) == len(built) > 5
    # One space is C0 across the middle, the other C1: equal but for discretisation.
    assert given == pytest.approx(built, rel=2e-3)


def test_given_patches_are_not_meshed():
    data = scene(HALVES, [6, 6])
    data["bodies"]["plate"]["backend"] = "fe"
    data["bodies"]["plate"]["mesh"]["fe"] = {"cell": "quadrilateral", "elements": [2, 2]}
    with pytest.raises(SceneError, match=r"bodies.plate.backend = 'fe': 'iga'"):
        read_scene(data)


@pytest.mark.parametrize(
    ("part", "value", "allowed"),
    [
        ("knots", [[0, 0, 1, 1], [0, 1, 0, 1]], "do not fall"),
        ("weights", [[1.0, 1.0], [1.0, -1.0]], "positive"),
        ("control_points", [[[0.0, 0.0]], [[0.5, 0.0]]], "shape"),
    ],
)
def test_faulty_patches_are_refused_by_name(part, value, allowed):
    patch = HALVES["patches"][0] | {part: value}
    geometry = HALVES | {"patches": [patch, HALVES["patches"][1]]}
    with pytest.raises(SceneError, match=allowed) as caught:
        read_scene(scene(geometry, [6, 6]))
    assert f"bodies.plate.geometry.patches.0.{part}" in str(caught.value)
    assert len(caught.value.faults) == 1
