"""NURBS patches that make one body: closed and turned ones, gaps, and what is refused."""

import numpy as np
import pytest
from closed_patches import LINE, annulus

from cea.errors import InputError
from scenes import run_modes, run_scene
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene

STEEL = {"E": 2e11, "nu": 0.3, "rho": 7800.0}
HELD = {"supports": [{"surface": "inner"}]}
RING = [14043.66, 16600.17, 16600.17, 22245.71, 22245.71]
"""Frequencies (Hz) of an annulus held inside, by finite elements of another program."""


def body(geometry, degree, elements, **fields):
    mesh = {"iga": {"degree": degree, "elements": elements}}
    return {"backend": "iga", "geometry": geometry, "material": STEEL, "mesh": mesh} | fields


def scene(geometry, degree, elements, max_frequency=30000.0, **fields):
    analysis = {"kind": "cea", "max_frequency": max_frequency}
    bodies = {"b": body(geometry, degree, elements, **fields)}
    return {"name": "patches", "bodies": bodies, "analysis": analysis}


def eigenvalues(data):
    values = run_modes(read_scene(data)).modes.eigenvalues
    return values[np.lexsort((values.real, np.round(values.imag, 2)))]


def frequencies(data):
    return np.sort(eigenvalues(data).imag) / (2 * np.pi)


def test_a_patch_that_closes_on_itself_is_a_ring():
    found = frequencies(scene(annulus(0.06, 0.1), [3, 3], [16, 3], **HELD))
    np.testing.assert_allclose(found[:5], RING, rtol=2e-5)


@pytest.mark.parametrize("quarters", [False, True])
def test_a_ring_under_pressure_is_that_of_lame(quarters):
    """Inner pressure, held outside: u = c (b^2 / r - r) with the traction -p at r = a."""
    a, b, pressure = 0.06, 0.1, 1e6
    data = scene(annulus(a, b, quarters=quarters), [3, 3], [4 if quarters else 16, 3])
    data["bodies"]["b"]["supports"] = [{"surface": "outer"}]
    data["loads"] = [{"surface": "b.inner", "pressure": pressure}]
    data["analysis"] = {"kind": "static"}
    lam = STEEL["E"] * STEEL["nu"] / ((1 + STEEL["nu"]) * (1 - 2 * STEEL["nu"]))
    mu = STEEL["E"] / (2 * (1 + STEEL["nu"]))
    expected = pressure / (2 * (mu * (b * b / a / a + 1) + lam)) * (b * b / a - a)
    result = run_scene(read_scene(data))
    points = result.system.bodies["b"].surfaces["inner"].gauss_points(2)
    found = result.displacements("b.inner", points.at)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), expected, rtol=1e-4)


def square(low, high, **fields):
    """A patch of degree 1 between two corners."""
    (a, b), (c, d) = low, high
    net = [[[a, b], [a, d]], [[c, b], [c, d]]]
    return {"degrees": [1, 1], "knots": [LINE, LINE], "control_points": net} | fields


def halves(gap=0.0, **fields):
    """A bar of two patches, a gap (m) between them; one held end."""
    patches = [square([0, 0], [0.05, 0.03]), square([0.05 + gap, 0], [0.1, 0.03])]
    return {"shape": "patches", "patches": patches, "faces": {"inner": [[0, 0, 0]]}} | fields


def bar():
    """The same of one patch with a knot that leaves the middle no more than continuous."""
    net = [[[x, y] for y in (0.0, 0.03)] for x in (0.0, 0.05, 0.1)]
    patch = {"degrees": [1, 1], "knots": [[0, 0, 0.5, 1, 1], LINE], "control_points": net}
    return {"shape": "patches", "patches": [patch], "faces": {"inner": [[0, 0, 0]]}}


def refused(geometry, words, elements=(4, 2), degree=(2, 2)):
    with pytest.raises((InputError, SceneError), match=words):
        run_modes(read_scene(scene(geometry, list(degree), list(elements), **HELD)))


def test_a_gap_is_refused_in_metres_and_closed_by_a_tolerance():
    refused(halves(1e-8), "are 1e-08 m apart: merge_nodes joins them")
    whole = frequencies(scene(bar(), [2, 2], [8, 2], **HELD))
    for gap in (0.0, 1e-8, -1e-8):
        merged = halves(gap, merge_nodes=1e-7)
        found = frequencies(scene(merged, [2, 2], [4, 2], **HELD))
        np.testing.assert_allclose(found, whole, rtol=1e-6)


def test_tolerances_that_are_not_small_are_refused():
    for distance in (0.0, -1.0, 0.02):
        with pytest.raises(SceneError, match=r"merge_nodes.*less than half the shortest"):
            read_scene(scene(halves(merge_nodes=distance), [2, 2], [4, 2], **HELD))


def test_a_patch_given_twice_is_refused():
    twice = {"shape": "patches", "faces": {"inner": [[0, 0, 0]]}}
    refused(twice | {"patches": [square([0, 0], [0.1, 0.03])] * 2}, "none given twice")
    mirrored = square([0, 0], [0.1, 0.03])
    mirrored["control_points"] = mirrored["control_points"][::-1]
    refused(twice | {"patches": [square([0, 0], [0.1, 0.03]), mirrored]}, "none given twice")
    quarters = annulus(0.06, 0.1, quarters=True)
    quarters["patches"].append(quarters["patches"][2])
    refused(quarters, "none given twice")


TURNED = halves() | {
    "patches": [
        square([0, 0], [0.05, 0.03]),
        {  # the right half, its parameters swapped and one reversed
            "degrees": [1, 1],
            "knots": [[0, 0, 2, 2], LINE],
            "control_points": [[[0.1, 0.03], [0.05, 0.03]], [[0.1, 0.0], [0.05, 0.0]]],
        },
    ]
}


def test_patches_whose_parameters_run_otherwise_are_joined():
    found = frequencies(scene(TURNED, [2, 2], [4, 4], **HELD))
    whole = frequencies(scene(halves(), [2, 2], [4, 4], **HELD))
    np.testing.assert_allclose(found, whole, rtol=1e-9)


def test_given_patches_are_not_meshed():
    data = scene(TURNED, [2, 2], [4, 2], **HELD)
    data["bodies"]["b"]["backend"] = "fe"
    data["bodies"]["b"]["mesh"]["fe"] = {"cell": "quadrilateral", "elements": [2, 2]}
    with pytest.raises(SceneError, match=r"bodies.b.backend = 'fe': 'iga'"):
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
    first, second = TURNED["patches"]
    data = scene(TURNED | {"patches": [first | {part: value}, second]}, [2, 2], [4, 2], **HELD)
    with pytest.raises(SceneError, match=allowed) as caught:
        read_scene(data)
    assert f"bodies.b.geometry.patches.0.{part}" in str(caught.value)
