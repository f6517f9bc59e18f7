"""Frictionless contact of elastic cylinders and spheres in closed form, as Hertz solved it.

Each body is a half space under its own contact, small beside body and radius; near the contact the
gap is r^2 / (2 R). With 1/R = 1/R_1 + 1/R_2 and 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2 the
pressure is peak sqrt(1 - r^2 / a^2) within the half width or radius a (K. L. Johnson, Contact
Mechanics, 1985, sections 4.2 and 5.6). Boundaries at a distance L disturb it by about (a / L)^2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.errors import InputError

Floats = NDArray[np.float64]


def contact_modulus(first: tuple[float, float], second: tuple[float, float] | None = None) -> float:
    """Modulus E* (N/m^2) of two bodies in contact.

    Parameters
    ----------
    first, second
        Young's modulus (N/m^2) and Poisson's ratio of each body; no second body is a rigid one.

    Raises
    ------
    InputError
        Unless E > 0 and -1 < nu <= 1/2.
    """
    compliance = 0.0
    for E, nu in (first, second) if second is not None else (first,):
        _require_positive("E", E)
        if not -1 < nu <= 0.5:
            raise InputError("nu", nu, "above -1, at most 0.5")
        compliance += (1 - nu**2) / E
    return 1 / compliance


def relative_radius(first: float, second: float = np.inf) -> float:
    """Radius R (m) of one body that leaves the gap of two; infinite for a flat one.

    Raises
    ------
    InputError
        Unless the radii are positive and one at least is finite.
    """
    for radius in (first, second):
        _require_positive("radius", radius)
    if np.isinf(first) and np.isinf(second):
        raise InputError("radius", first, "finite for one of the bodies")
    return 1 / (1 / first + 1 / second)


@dataclass(frozen=True)
class LineContact:
    """Parallel cylinders, in plane strain.

    Parameters
    ----------
    load
        Force per length of the cylinders (N/m).
    radius
        Relative radius R (m).
    modulus
        Contact modulus E* (N/m^2).
    """

    load: float
    radius: float
    modulus: float

    def __post_init__(self) -> None:
        _check(self.load, self.radius, self.modulus)

    @property
    def half_width(self) -> float:
        """Half width a of the contact (m): a^2 = 4 F R / (pi E*)."""
        return float(np.sqrt(4 * self.load * self.radius / (np.pi * self.modulus)))

    @property
    def peak_pressure(self) -> float:
        """Largest pressure (N/m^2), 2 F / (pi a)."""
        return 2 * self.load / (np.pi * self.half_width)

    def pressure(self, x: Floats) -> Floats:
        """Pressure (N/m^2) at distances x from the middle of the contact (m)."""
        return self.peak_pressure * _half_circle(x / self.half_width)

    def approach_of_layer(self, E: float, nu: float, depth: float) -> float:
        """Approach (m) of the surface of one body to its points at a depth below the contact.

        In plane strain it grows without end with the depth d, of which a is a small part:
        F (1 - nu^2) / (pi E) (2 ln(2 d / a) - nu / (1 - nu)) (Johnson, eq. 5.57).

        Parameters
        ----------
        E, nu
            Young's modulus (N/m^2) and Poisson's ratio of the body.
        depth
            Depth d (m).
        """
        _require_positive("depth", depth)
        compliance = contact_modulus((E, nu)) * np.pi / self.load
        return float((2 * np.log(2 * depth / self.half_width) - nu / (1 - nu)) / compliance)


@dataclass(frozen=True)
class PointContact:
    """Spheres.

    Parameters
    ----------
    load
        Force (N).
    radius
        Relative radius R (m).
    modulus
        Contact modulus E* (N/m^2).
    """

    load: float
    radius: float
    modulus: float

    def __post_init__(self) -> None:
        _check(self.load, self.radius, self.modulus)

    @property
    def contact_radius(self) -> float:
        """Radius a of the contact (m): a^3 = 3 F R / (4 E*)."""
        return float(np.cbrt(3 * self.load * self.radius / (4 * self.modulus)))

    @property
    def peak_pressure(self) -> float:
        """Largest pressure (N/m^2), 3 F / (2 pi a^2)."""
        return 3 * self.load / (2 * np.pi * self.contact_radius**2)

    @property
    def approach(self) -> float:
        """Approach of points far from the contact (m), a^2 / R."""
        return self.contact_radius**2 / self.radius

    def pressure(self, r: Floats) -> Floats:
        """Pressure (N/m^2) at distances r from the middle of the contact (m)."""
        return self.peak_pressure * _half_circle(r / self.contact_radius)


def _half_circle(ratio: Floats) -> Floats:
    return np.sqrt(np.maximum(1 - np.asarray(ratio) ** 2, 0.0))


def _check(load: float, radius: float, modulus: float) -> None:
    for name, value in (("load", load), ("radius", radius), ("modulus", modulus)):
        _require_positive(name, value)
        if not np.isfinite(value):
            raise InputError(name, value, "a finite number")


def _require_positive(name: str, value: float) -> None:
    if not value > 0:
        raise InputError(name, value, "a positive number")
