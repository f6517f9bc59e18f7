"""Damping of contacts that slide: against the derivative of friction forces, and by power."""

import numpy as np
import pytest
from blocks import FORMULATIONS, PLACEMENTS, assemble, coarse, two_blocks
from covering import covering
from petsc_matrices import to_numpy

from meshes.placement import Placement

PRESSURE, SPEED, SLOPE, MU = 3.0, 0.5, -0.2, 0.4
AREA = 0.5 * 0.6
"""Of side a of the two blocks."""
GPTS = {"method": "gpts", "points": 2}


def scene(backend, formulation, *, placement=None, mu=MU, **contact):
    sliding = {"pressure": PRESSURE, "speed": SPEED, "mu_slope": SLOPE}
    fields = {"mu": mu, "sliding": sliding} | contact
    return coarse(two_blocks(backend, formulation, placement, **fields), degree=2)


def damping(data):
    """C of a scene, its power in translations of the bodies against each other, the area."""
    system = assemble(data, leave_out=False)
    n = system.bodies["upper"].stiffness().getSize()[0]
    shift = np.tile(np.eye(3), (system.size // 3, 1))
    shift[n:] = 0.0
    # The second half of a full pass has points on b, whose area opposite a depends on the rule.
    area = np.mean([contact.interface.points.weight.sum() for contact in system.contacts])
    C = to_numpy(system.pencil().at().damping)
    return C, shift.T @ C @ shift, area


@pytest.mark.parametrize(
    ("backend", "formulation", "placement"),
    covering(["fe", "iga"], FORMULATIONS, PLACEMENTS),
    indirect=True,
)
def test_power_of_a_translation(backend, formulation, placement):
    """Along k it is sigma mu' A, across it mu sigma A / v, and none along the normal.

    Blocks that stand turned have a full pass.
    """
    full_pass = bool(placement)
    options = {"placement": placement, "full_pass": full_pass, "max_missed": 0.9}
    data = scene(backend, formulation, **options)
    C, power, area = damping(data)
    k = np.array(data["contacts"]["interface"]["friction_direction_on_a"]["vector"])
    k /= np.linalg.norm(k)
    turn = Placement(tuple(placement["axis"]), placement["angle"]).rotation if placement else None
    normal = np.array([0.0, 0.0, 1.0]) if turn is None else turn @ [0.0, 0.0, 1.0]
    along = SLOPE * PRESSURE * np.outer(k, k)
    across = np.cross(normal, k)
    expected = area * (along + MU * PRESSURE / SPEED * np.outer(across, across))
    assert power == pytest.approx(expected, rel=1e-10, abs=1e-11)
    assert area == pytest.approx(AREA, rel=0.5 if full_pass else 1e-10)
    assert (C == C.T).all()
    both = np.tile(np.eye(3), (len(C) // 3, 1))
    assert np.abs(C @ both).max() < 1e-12


def test_it_is_the_derivative_of_the_friction_force(backend):
    """Of the traction - mu(|w|) sigma w / |w|, w the velocity of a relative to b."""
    k = np.array([1.0, 0.5, 0.0]) / np.hypot(1.0, 0.5)

    def force(velocity):
        """On a, over the whole contact."""
        w = (velocity - SPEED * k) * [1.0, 1.0, 0.0]
        size = np.linalg.norm(w)
        return -AREA * PRESSURE * (MU + SLOPE * (size - SPEED)) * w / size

    step = 1e-5
    slopes = [(force(step * e) - force(-step * e)) / (2 * step) for e in np.eye(3)]
    _, power, _ = damping(scene(backend, GPTS | {"points": 3}))
    assert power == pytest.approx(-np.transpose(slopes), rel=1e-8, abs=1e-8)


def test_without_friction_only_the_slope_is_left(backend):
    data = scene(backend, GPTS, mu=0.0)
    pencil = assemble(data).pencil()
    assert "contacts.interface.sliding.speed" not in pencil.parameters
    assert "contacts.interface.sliding.mu_slope" in pencil.parameters
    assert np.linalg.matrix_rank(to_numpy(pencil.at().damping)) > 0
    del data["contacts"]["interface"]["sliding"]["mu_slope"]
    assert not assemble(data).pencil().at().quadratic
