"""Damping of a body in proportion to its mass and its stiffness."""

from dataclasses import dataclass
from math import pi

from cea.arrays import is_number
from cea.errors import InputError

_ROUNDING = 1e-15
"""Of ratios that are proportional to the frequency, or to its inverse."""


@dataclass(frozen=True)
class RayleighDamping:
    """Rayleigh damping C = alpha M + beta K, K with the springs of the body.

    A mode of the body alone with the angular frequency omega has the damping ratio
    alpha / (2 omega) + beta omega / 2 (Bathe, Finite Element Procedures, sec. 9.3.3).

    Parameters
    ----------
    alpha
        Factor on the mass (1/s), zero or positive.
    beta
        Factor on the stiffness (s), zero or positive.
    """

    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        for name, value, unit in (("alpha", self.alpha, "1/s"), ("beta", self.beta, "s")):
            if not (is_number(value) and value >= 0):
                raise InputError(f"damping.{name}", value, f"zero or positive, finite ({unit})")

    @classmethod
    def of_ratios(
        cls, ratios: tuple[float, float], frequencies: tuple[float, float]
    ) -> "RayleighDamping":
        """Damping that has given ratios at two frequencies.

        Parameters
        ----------
        ratios
            Damping ratios, 1 being critical.
        frequencies
            Frequencies (Hz), positive and different.

        Raises
        ------
        InputError
            When alpha or beta would be negative: ratios may not fall faster than the inverse of the
            frequency, nor rise faster than the frequency.
        """
        if not all(is_number(f) and f > 0 for f in frequencies) or len(set(frequencies)) < 2:
            raise InputError("damping.frequencies", frequencies, "two different positive ones (Hz)")
        if not all(is_number(ratio) and ratio >= 0 for ratio in ratios):
            raise InputError("damping.ratios", ratios, "zero or positive")
        (f, z), (F, Z) = sorted(zip(frequencies, ratios, strict=True))
        shared, rounding = (F - f) * (F + f), _ROUNDING * max(ratios) * F
        of_mass, of_stiffness = z * F - Z * f, Z * F - z * f
        if min(of_mass, of_stiffness) < -rounding:
            allowed = f"{z * f / F:.6g} to {z * F / f:.6g} at {F} Hz where {z} at {f} Hz"
            raise InputError("damping.ratios", ratios, allowed)
        alpha = 4 * pi * f * F * max(of_mass, 0.0) / shared
        return cls(alpha, max(of_stiffness, 0.0) / (pi * shared))

    def ratio(self, frequency: float) -> float:
        """Damping ratio of a mode of the body alone at a frequency (Hz)."""
        omega = 2 * pi * frequency
        return self.alpha / (2 * omega) + self.beta * omega / 2
