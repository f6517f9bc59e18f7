"""Hertz contact: radius and peak pressure converge to the closed form where c_n is stiff.

The law yields by p / c_n, which makes a contact wider and lower by a part that falls like 1 / c_n;
elements of size h know its rim to h, beyond which the pressure falls like the root of the distance.
With c_n h kept, so that contact and elements stay as stiff beside each other, both errors fall like
h: order 1 for the radius by the second moment of the pressure, and for the pressure over the
contact in the mean square; for the pressure in the middle order 1 at least, since what elements err
there, far from the rim, falls faster than what the law yields.
"""

import numpy as np
import pytest
from hertz_scenes import CYLINDER, FINE, closed_form, radius_of, rate, refined

from scenes import load_scene

ORDER = 1.0
TOLERANCE = 0.35
"""Of orders: where the rim lies in its element changes from mesh to mesh."""


def element(name, row):
    """Size of an element in the contact, relative to its radius, on a row of meshes."""
    hertz, _ = closed_form(load_scene(name))
    return FINE / np.array(row) / radius_of(hertz)


def check_orders(found, row, name):
    assert rate(row, found["radius"]) == pytest.approx(ORDER, abs=TOLERANCE)
    assert rate(row, found["peak"]) > ORDER - TOLERANCE
    assert (np.abs(found["closed"]) < element(name, row)).all()
    assert np.abs(found["load"]).max() < 1e-9


@pytest.mark.convergence
@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_a_cylinder_on_a_block(backend):
    """Elements of the lower block are smaller by a fifth, and match none of the upper one."""
    row = (8, 11, 16, 23, 32)
    segments = {"method": "segments"}
    found = refined(CYLINDER, backend, row, first_c_n=1e15, formulation=segments, more_below=0.25)
    check_orders(found, row, CYLINDER)
    assert abs(found["radius"][-1]) < 5e-4
    assert abs(found["peak"][-1]) < 5e-4
