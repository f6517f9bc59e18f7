"""Laws of contact: slopes are derivatives of pressures, and what cannot be is refused."""

import numpy as np
import pytest

from cea.contact.friction import Friction
from cea.contact.laws import LinearLaw, NormalCompliance
from cea.errors import InputError

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


def test_open_contact_has_neither_pressure_nor_slope():
    law, open_ = NormalCompliance(3e10, 1.0), np.array([-1e-5, -1e-300, 0.0])
    assert not law.pressure(open_).any()
    assert not law.slope(open_).any()


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: LinearLaw(0.0), "p"),
        (lambda: LinearLaw(np.array([1.0, -2.0])), "p"),
        (lambda: LinearLaw(np.array([1.0, np.inf])), "p"),
        (lambda: LinearLaw(np.nan), "p"),
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
