"""Hertz contact: the pressure presses both surfaces flat onto each other, by integrals over it."""

import numpy as np
import pytest
from hertz import LineContact, PointContact, contact_modulus, relative_radius
from scipy.integrate import quad

from cea.errors import InputError

STEEL, PAD = (2.1e11, 0.3), (8e9, 0.25)
MODULUS = contact_modulus(STEEL, PAD)
LINE = LineContact(load=3e5, radius=0.4, modulus=MODULUS)
POINT = PointContact(load=2e3, radius=0.4, modulus=MODULUS)


def integral(function, low, high):
    return quad(function, low, high, epsabs=0, epsrel=1e-11, limit=200)[0]


def test_pressures_add_up_to_the_load():
    a = LINE.half_width
    along = integral(lambda t: LINE.pressure(a * np.sin(t)) * a * np.cos(t), -np.pi / 2, np.pi / 2)
    assert along == pytest.approx(LINE.load, rel=1e-10)
    a = POINT.contact_radius
    rings = integral(
        lambda t: POINT.pressure(a * np.sin(t)) * 2 * np.pi * a**2 * np.sin(t) * np.cos(t),
        0,
        np.pi / 2,
    )
    assert rings == pytest.approx(POINT.load, rel=1e-10)


def test_cylinders_are_pressed_onto_each_other():
    """Flamant: u' = -2 / (pi E*) int p(s) / (x - s) ds must be that of the gap, -x / R.

    With s = a sin(t) and p(s) less p(x), whose own integral over the contact is a logarithm.
    """
    a = LINE.half_width
    for x in np.array([0.15, 0.5, 0.85]) * a:
        at_x = float(LINE.pressure(x))

        def slope(t, x=x, at_x=at_x):
            s = a * np.sin(t)
            return (LINE.pressure(s) - at_x) / (x - s) * a * np.cos(t)

        middle = np.arcsin(x / a)
        regular = integral(slope, -np.pi / 2, middle) + integral(slope, middle, np.pi / 2)
        principal = regular + at_x * np.log((a + x) / (a - x))
        assert -2 / (np.pi * MODULUS) * principal == pytest.approx(-x / LINE.radius, rel=1e-6)


def test_spheres_are_pressed_onto_each_other():
    """Boussinesq: u = int p / (pi E* distance) dA is the approach less the gap r^2 / (2 R).

    Chords through the point: in polar coordinates about it the distance cancels.
    """
    a = POINT.contact_radius
    for r in np.array([0.0, 0.4, 0.8]) * a:

        def along(phi, r=r):
            end = -r * np.cos(phi) + np.sqrt(a**2 - (r * np.sin(phi)) ** 2)
            # s = end (1 - v^2) takes the root at the rim away.
            return integral(
                lambda v: (
                    POINT.pressure(
                        np.sqrt(
                            r**2 + (end * (1 - v**2)) ** 2 + 2 * r * end * (1 - v**2) * np.cos(phi)
                        )
                    )
                    * 2
                    * v
                    * end
                ),
                0,
                1,
            )

        pressed = 2 * integral(along, 0, np.pi) / (np.pi * MODULUS)
        assert pressed == pytest.approx(POINT.approach - r**2 / (2 * POINT.radius), rel=1e-7)


def test_a_layer_is_pressed_in_by_the_strain_below_the_contact():
    """Strains on the axis below the contact (Johnson, eq. 4.46), integrated over the depth."""
    E, nu = STEEL
    a, peak = LINE.half_width, LINE.peak_pressure

    def strain(z):
        across = -peak / a * ((a**2 + 2 * z**2) / np.sqrt(a**2 + z**2) - 2 * z)
        down = -peak * a / np.sqrt(a**2 + z**2)
        return -((1 - nu**2) * down - nu * (1 + nu) * across) / E

    depth = 200 * a
    pressed = integral(strain, 0, depth)
    assert LINE.approach_of_layer(E, nu, depth) == pytest.approx(pressed, rel=1e-5)


def test_two_bodies_as_one():
    assert relative_radius(0.3, 0.6) == pytest.approx(0.2)
    assert relative_radius(0.3) == 0.3
    assert contact_modulus(STEEL) == pytest.approx(2.1e11 / 0.91)
    assert contact_modulus(STEEL, STEEL) == pytest.approx(2.1e11 / 1.82)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: LineContact(0.0, 1.0, 1.0), "load"),
        (lambda: PointContact(1.0, float("inf"), 1.0), "radius"),
        (lambda: PointContact(1.0, 1.0, float("nan")), "modulus"),
        (lambda: contact_modulus((-1.0, 0.3)), "E"),
        (lambda: contact_modulus((1.0, 0.6)), "nu"),
        (lambda: relative_radius(float("inf")), "radius"),
        (lambda: relative_radius(-1.0), "radius"),
        (lambda: LINE.approach_of_layer(1.0, 0.3, 0.0), "depth"),
    ],
)
def test_what_is_no_hertz_contact_is_refused(make, field):
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.field == field
