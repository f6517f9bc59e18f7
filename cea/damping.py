"""Damping of a body: in proportion to its mass and its stiffness, and of its modes one by one."""

from dataclasses import dataclass
from math import pi

import numpy as np

from cea.arrays import Floats, is_number
from cea.errors import require

_ROUNDING = 1e-15  # of ratios that are proportional to the frequency, or to its inverse


@dataclass(frozen=True)
class RayleighDamping:
    """Rayleigh damping C = alpha M + beta K, K with the springs of the body.

    A mode of the body alone with the angular frequency omega has the damping ratio
    alpha / (2 omega) + beta omega / 2 (Bathe, Finite Element Procedures, sec. 9.3.3). Of a body
    that rotates all but its springs is carried along with the material (:mod:`cea.rotation`).

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
            allowed = f"zero or positive, finite ({unit})"
            require(is_number(value) and value >= 0, f"damping.{name}", value, allowed)

    @classmethod
    def of_ratios(
        cls, ratios: tuple[float, float], frequencies: tuple[float, float]
    ) -> "RayleighDamping":
        """Damping that has given ratios, 1 being critical, at two different frequencies (Hz).

        Refused where alpha or beta would be negative: ratios may not fall faster than the inverse
        of the frequency, nor rise faster than the frequency.
        """
        different = all(map(_is_positive, frequencies)) and len(set(frequencies)) == 2
        allowed = "two different positive ones (Hz)"
        require(different, "damping.frequencies", frequencies, allowed)
        positive = all(is_number(ratio) and ratio >= 0 for ratio in ratios)
        require(positive, "damping.ratios", ratios, "zero or positive")
        (f, z), (F, Z) = sorted(zip(frequencies, ratios, strict=True))
        shared, rounding = (F - f) * (F + f), _ROUNDING * max(ratios) * F
        of_mass, of_stiffness = z * F - Z * f, Z * F - z * f
        allowed = f"{z * f / F:.6g} to {z * F / f:.6g} at {F} Hz where {z} at {f} Hz"
        require(min(of_mass, of_stiffness) >= -rounding, "damping.ratios", ratios, allowed)
        alpha = 4 * pi * f * F * max(of_mass, 0.0) / shared
        return cls(alpha, max(of_stiffness, 0.0) / (pi * shared))


@dataclass(frozen=True)
class ModalDamping:
    """Damping of the modes of a body alone, held by its supports and springs, at rest.

    With modes phi_j, phi_i^T M phi_j = delta_ij, angular frequencies omega_j and damping ratios
    zeta_j it is

        C = sum_j 2 zeta_j omega_j (M phi_j) (M phi_j)^T,

    so that lambda_j = omega_j (-zeta_j +- i sqrt(1 - zeta_j^2)) of the body alone (Clough, Penzien,
    Dynamics of Structures, sec. 12.5). Rigid motions have none, nor have modes beyond those named.
    Of a body that rotates it is carried along with the material (:mod:`cea.rotation`).

    Parameters
    ----------
    ratio
        Damping ratio of all modes up to ``max_frequency``, zero or more and below 1, critical.
    max_frequency
        Frequency (Hz) up to which modes are damped.
    ratios
        Given instead: ratios of the lowest modes by rising frequency, rigid motions not counted;
        or, with ``frequencies``, of modes at these, linear between them.
    frequencies
        Rising frequencies (Hz). Modes below the first have the first ratio, modes above the last
        none.

    Raises
    ------
    InputError
        When values are out of bounds, or neither all of one kind nor of the other are given.
    """

    ratio: float | None = None
    max_frequency: float | None = None
    ratios: tuple[float, ...] | None = None
    frequencies: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        ratio, ratios, table = self.ratio, self.ratios, self.frequencies
        allowed = "one for all modes up to max_frequency, or ratios of the lowest modes"
        require((ratio is None) != (ratios is None), "ratio", ratio, allowed)
        highest = self.max_frequency
        together = (ratio is None) == (highest is None)
        require(together, "max_frequency", highest, "given where ratio is (Hz)")
        beside = table is None or ratios is not None
        require(beside, "frequencies", table, "given beside ratios alone")
        positive = highest is None or _is_positive(highest)
        require(positive, "max_frequency", highest, "positive, finite (Hz)")
        require(ratio is None or _is_ratio(ratio), "ratio", ratio, _RATIO)
        valid = ratios is None or (bool(ratios) and all(map(_is_ratio, ratios)))
        require(valid, "ratios", ratios, f"one or more, each {_RATIO}")
        if table is not None and ratios is not None:
            rising = all(map(_is_positive, table)) and bool(np.all(np.diff(table) > 0))
            require(rising, "frequencies", table, "positive, finite and rising (Hz)")
            same = len(table) == len(ratios)
            require(same, "frequencies", table, f"as many as ratios, {len(ratios)}")

    @property
    def end(self) -> float | None:
        """Frequency (Hz) above which no mode is damped; None where modes are counted instead."""
        return self.max_frequency if self.frequencies is None else self.frequencies[-1]

    @property
    def acts(self) -> bool:
        """Whether anything is damped."""
        return bool(self.ratio) or any(self.ratios or ())

    def factors_at(self, frequencies: Floats) -> Floats:
        """Damping ratios of the lowest elastic modes at frequencies (Hz), relative to ``ratio``."""
        if self.max_frequency is not None:
            return np.where(frequencies <= self.max_frequency, 1.0, 0.0)
        ratios = np.asarray(self.ratios)
        if self.frequencies is not None:
            inside = frequencies <= self.frequencies[-1]
            return np.where(inside, np.interp(frequencies, self.frequencies, ratios), 0.0)
        factors = np.zeros(len(frequencies))
        factors[: len(ratios)] = ratios[: len(factors)]
        return factors


_RATIO = "zero or more and below 1, which is critical: 0.01 is one per cent"


def _is_ratio(value: float) -> bool:
    return is_number(value) and 0 <= value < 1


def _is_positive(value: float) -> bool:
    return is_number(value) and value > 0
