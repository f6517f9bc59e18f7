"""Laws of contact points: slopes, open parts, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from blocks import assemble, coarse, two_blocks
from petsc_matrices import to_numpy

from cea.contact.interface import pair
from cea.contact.pressure_and_friction import Friction, LinearLaw, NormalCompliance
from cea.errors import InputError
from cea.matrices import applied

LAWS = [
    LinearLaw(3.0),
    LinearLaw(np.linspace(1, 2, 41)),
    *(NormalCompliance(3e10, m) for m in (1.0, 1.5, 2.0, 2.5, 3.3)),
]


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_the_slope_is_the_derivative_of_the_pressure(law):
    penetration = np.linspace(-1e-5, 2e-5, 41)
    step = 1e-11
    difference = law.pressure(penetration + step) - law.pressure(penetration - step)
    scale = np.abs(law.slope(penetration)).max()
    assert law.slope(penetration) == pytest.approx(difference / (2 * step), abs=1e-5 * scale)
    if isinstance(law, NormalCompliance):
        open_ = np.array([-1e-5, -1e-300, 0.0])
        assert not law.pressure(open_).any()
        assert not law.slope(open_).any()


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: LinearLaw(0.0), "p"),
        (lambda: LinearLaw(np.array([1.0, -2.0])), "p"),
        (lambda: LinearLaw(np.array([1.0, np.inf])), "p"),
        (lambda: NormalCompliance(0.0, 2.0), "c_n"),
        (lambda: NormalCompliance(np.inf, 2.0), "c_n"),
        (lambda: NormalCompliance(1.0, 0.9), "m_n"),
        (lambda: Friction(np.array([0.1, -0.1]), None), "mu"),
    ],
)
def test_numbers_that_make_no_law_are_refused(make, field):
    with pytest.raises(InputError) as refused:
        make()
    assert refused.value.field == field


def lifted(backend, formulation, field="where(x < 0.37, 0, 3.0)"):
    """Frictionless blocks of which a part lifted off: p is zero there.

    The closed part begins inside of elements of either side; side a reaches from 0.2 to 0.7.
    """
    return two_blocks(backend, formulation, held=True, mu=0.0, P=None, p=field)


def test_open_points_bear_no_force(backend, formulation):
    """The pressure is zero where p is, and adds up to p times the closed area elsewhere."""
    system = assemble(lifted(backend, formulation))
    (contact,) = system.contacts
    expansion, motion = system.bodies["upper"].expansion, system.vector()
    down = np.tile([0.0, 0.0, -1.0], expansion.getLocalSize()[0] // 3)
    motion.array[system.pieces["upper"].rows] = applied(expansion, down, transposed=True)
    points, open_points = contact.interface.points, contact.slope == 0
    assert 0 < open_points.sum() < len(points)
    pressure = contact.pressure(motion)
    assert (pressure[open_points] == 0).all()
    assert float(points.weight @ pressure) == pytest.approx(contact.P, rel=1e-12)
    closed = 0.33 * 0.6
    assert contact.P / closed == pytest.approx(3.0, rel=0.35)


@pytest.mark.parametrize(
    ("field", "told"), [("x - 0.4", "zero or positive"), ("0*x", "positive .* somewhere")]
)
def test_negative_stiffness_and_none_at_all_are_refused(backend, field, told):
    with pytest.raises(InputError, match=told) as caught:
        assemble(lifted(backend, {"method": "segments"}, field))
    assert caught.value.field == "contacts.interface.p"


def test_mortar_keeps_no_force_that_is_a_sum_of_others(backend):
    """Mortar forces are as many as traces that are independent over what is closed."""
    closed, part = (
        assemble(lifted(backend, {"method": "mortar"}, field)).contacts[0]
        for field in ("3.0", "where(x < 0.68, 0, 3.0)")
    )
    assert 0 < part.gap.getSize()[0] < closed.gap.getSize()[0]
    gram = to_numpy(part.compliance(part.slope))
    scale = 1 / np.sqrt(np.diag(gram))
    assert np.linalg.eigvalsh(scale[:, None] * gram * scale).min() > 1e-15


@pytest.mark.parametrize("wrong", [-1e-3, np.nan, np.inf])
def test_weights_that_are_negative_or_no_numbers_are_refused(backend, wrong):
    data = coarse(two_blocks(backend, {"method": "gpts", "points": 3}, held=True))
    interface = assemble(data).contacts[0].interface
    points = interface.a.gauss_points(3)
    weight = points.weight.copy()
    weight[5] = wrong
    with pytest.raises(InputError, match=r"contact\.formulation\.weights"):
        pair(interface.a, interface.b, replace(points, weight=weight))
