"""Contacts of which a part has lifted off: p is zero there."""

import numpy as np
import pytest
from blocks import assemble, two_blocks

from cea.errors import InputError
from cea.matrices import applied
from comparisons.stability.dense import array

FREE = "where(x < 0.37, 0, 3.0)"
"""The closed part begins inside of elements of either side; side a reaches from 0.2 to 0.7."""
CLOSED = 0.33 * 0.6
"""Area of what is closed (m^2)."""


def lifted(backend, formulation, field=FREE, **options):
    data = two_blocks(backend, formulation, held=True, **options)
    contact = data["contacts"]["interface"]
    del contact["P"]
    contact["p"] = field
    return data


def closure(system):
    """Force on each unknown of upper (N) when it moves onto the other side by 1 m everywhere."""
    (contact,) = system.contacts
    motion = system.vector()
    upper = system.bodies["upper"]
    down = np.tile([0.0, 0.0, -1.0], upper.expansion.getSizes()[0][1] // 3)
    motion.array[system.pieces["upper"].rows] = applied(upper.expansion, down, transposed=True)
    return contact, motion


def test_open_points_bear_no_force(backend, formulation):
    """The pressure is zero where p is, and adds up to p times the closed area elsewhere."""
    system = assemble(lifted(backend, formulation, mu=0.0))
    contact, motion = closure(system)
    points, p = contact.interface.points, contact.slope
    open_points = p == 0
    assert 0 < open_points.sum() < len(points)
    pressure = contact.pressure(motion)
    assert (pressure[open_points] == 0).all()
    force = float(points.weight @ pressure)
    assert force == pytest.approx(contact.P, rel=1e-12)
    mean = contact.P / CLOSED
    assert mean == pytest.approx(3.0, rel=0.35)


@pytest.mark.parametrize(
    ("field", "told"), [("x - 0.4", "zero or positive"), ("0*x", "positive .* somewhere")]
)
def test_negative_stiffness_and_none_at_all_are_refused(backend, field, told):
    with pytest.raises(InputError, match=told) as caught:
        assemble(lifted(backend, {"method": "segments"}, field))
    assert caught.value.field == "contacts.interface.p"


def test_mortar_keeps_no_force_that_is_a_sum_of_others(backend):
    """Mortar forces are as many as traces that are independent over what is closed."""
    closed = assemble(lifted(backend, {"method": "mortar"}, "3.0"))
    part = assemble(lifted(backend, {"method": "mortar"}, "where(x < 0.68, 0, 3.0)"))
    counts = [system.contacts[0].gap.getSize()[0] for system in (closed, part)]
    assert 0 < counts[1] < counts[0]
    gram = array(part.contacts[0].compliance(part.contacts[0].slope))
    scale = 1 / np.sqrt(np.diag(gram))
    assert np.linalg.eigvalsh(scale[:, None] * gram * scale).min() > 1e-15
