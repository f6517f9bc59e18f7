"""Damping of contacts that slide, by its power."""

import numpy as np
import pytest
from blocks import FORMULATIONS, PLACEMENTS, assemble, coarse, two_blocks
from covering import covering
from petsc_matrices import to_numpy

PRESSURE, SPEED, SLOPE = 3.0, 0.5, -0.2
AREA = 0.5 * 0.6
"""Of side a of the two blocks."""


@pytest.mark.parametrize(
    ("backend", "formulation", "placement", "mu"),
    covering(["fe", "iga"], FORMULATIONS, PLACEMENTS, [0.4, 0.0], strength=1),
    indirect=["backend", "formulation", "placement"],
)
def test_power_of_a_translation(backend, formulation, placement, mu):
    """Along k it is sigma mu' A, across it mu sigma A / v, and none along the normal.

    This is the derivative of the friction force -mu(|w|) sigma A w / |w| in the velocity w of a
    relative to b. Blocks that stand turned have a full pass.
    """
    full_pass = bool(placement)
    sliding = {"pressure": PRESSURE, "speed": SPEED, "mu_slope": SLOPE}
    options = {"full_pass": full_pass, "max_missed": 0.9, "mu": mu, "sliding": sliding}
    data = coarse(two_blocks(backend, formulation, placement, **options), degree=2)
    system = assemble(data, leave_out=False)
    C = to_numpy(system.pencil().at().damping)
    shift = np.tile(np.eye(3), (system.size // 3, 1))
    assert np.abs(C @ shift).max() < 1e-12
    shift[system.bodies["upper"].stiffness().getSize()[0] :] = 0.0
    # The second half of a full pass has points on b, whose area opposite a depends on the rule.
    area = np.mean([contact.interface.points.weight.sum() for contact in system.contacts])
    assert area == pytest.approx(AREA, rel=0.5 if full_pass else 1e-10)
    k = np.array(data["contacts"]["interface"]["friction_direction_on_a"]["vector"])
    k /= np.linalg.norm(k)
    normal = system.bodies["lower"].surfaces["z_max"].gauss_points(1).normal[0]
    across = np.cross(normal, k)
    expected = SLOPE * PRESSURE * np.outer(k, k) + mu * PRESSURE / SPEED * np.outer(across, across)
    assert shift.T @ C @ shift == pytest.approx(area * expected, rel=1e-10, abs=1e-11)
    assert (C == C.T).all()
