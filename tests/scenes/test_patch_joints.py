"""NURBS patches that make one body: closed and turned ones, gaps, and what is refused."""

import numpy as np
import pytest
from blocks import alone
from closed_patches import LINE, annulus

from cea.errors import InputError
from scenes import SceneError, read_scene, run_modes, run_scene

STEEL = {"E": 2e11, "nu": 0.3, "rho": 7800.0}
RING = [14043.66, 16600.17, 16600.17, 22245.71, 22245.71]
"""Frequencies (Hz) of an annulus held inside, by finite elements of another program."""


def scene(geometry, degree, elements, max_frequency=30000.0, held="inner"):
    body = {"backend": "iga", "geometry": geometry, "material": STEEL}
    body |= {"mesh": {"iga": {"degree": [degree] * 2, "elements": elements}}}
    return alone(body | {"supports": [{"surface": held}]}, max_frequency)


def frequencies(*arguments):
    return np.sort(run_modes(read_scene(scene(*arguments))).eigenvalues.imag) / (2 * np.pi)


def test_a_patch_that_closes_on_itself_is_a_ring():
    found = frequencies(annulus(0.06, 0.1), 3, [16, 3])
    np.testing.assert_allclose(found[:5], RING, rtol=2e-5)


@pytest.mark.parametrize("quarters", [False, True])
def test_a_ring_under_pressure_is_that_of_lame(quarters):
    """Inner pressure, held outside: u = c (b^2 / r - r) with the traction -p at r = a."""
    a, b, pressure = 0.06, 0.1, 1e6
    geometry, elements = annulus(a, b, quarters=quarters), [4 if quarters else 16, 3]
    data = scene(geometry, 3, elements, None, held="outer")
    data["loads"] = [{"surface": "part.inner", "pressure": pressure}]
    lam = STEEL["E"] * STEEL["nu"] / ((1 + STEEL["nu"]) * (1 - 2 * STEEL["nu"]))
    mu = STEEL["E"] / (2 * (1 + STEEL["nu"]))
    expected = pressure / (2 * (mu * (b * b / a / a + 1) + lam)) * (b * b / a - a)
    result = run_scene(read_scene(data))
    points = result.system.bodies["part"].surfaces["inner"].gauss_points(2)
    found = result.displacements("part.inner", points.at)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), expected, rtol=1e-4)


def square(low, high):
    """A patch of degree 1 between two corners."""
    (a, b), (c, d) = low, high
    net = [[[a, b], [a, d]], [[c, b], [c, d]]]
    return {"degrees": [1, 1], "knots": [LINE, LINE], "control_points": net}


def patches(*every, **fields):
    """A bar of patches; the left end of the first is named."""
    return {"shape": "patches", "patches": list(every), "faces": {"inner": [[0, 0, 0]]}} | fields


def halves(gap=0.0, **fields):
    """A bar of two patches, a gap (m) between them."""
    return patches(square([0, 0], [0.05, 0.03]), square([0.05 + gap, 0], [0.1, 0.03]), **fields)


def test_a_gap_is_refused_in_metres_and_closed_by_a_tolerance():
    """The same bar of one patch has a knot that leaves its middle no more than continuous."""
    with pytest.raises(InputError, match="are 1e-08 m apart: merge_nodes joins them"):
        frequencies(halves(1e-8), 2, [4, 2])
    net = [[[x, y] for y in (0.0, 0.03)] for x in (0.0, 0.05, 0.1)]
    bar = {"degrees": [1, 1], "knots": [[0, 0, 0.5, 1, 1], LINE], "control_points": net}
    whole = frequencies(patches(bar), 2, [8, 2])
    for gap in (0.0, 1e-8, -1e-8):
        found = frequencies(halves(gap, merge_nodes=1e-7), 2, [4, 2])
        np.testing.assert_allclose(found, whole, rtol=1e-6)


WHOLE = square([0, 0], [0.1, 0.03])
MIRRORED = WHOLE | {"control_points": WHOLE["control_points"][::-1]}
QUARTERS = annulus(0.06, 0.1, quarters=True)
TWICE = {
    "mirrored": patches(WHOLE, MIRRORED),
    "quarters": QUARTERS | {"patches": [*QUARTERS["patches"], QUARTERS["patches"][2]]},
}


@pytest.mark.parametrize("name", TWICE)
def test_a_patch_given_twice_is_refused(name):
    with pytest.raises((InputError, SceneError), match="none given twice"):
        frequencies(TWICE[name], 2, [4, 2])
