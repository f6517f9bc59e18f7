"""What a scene says of small velocities: damping of bodies, contacts that slide at a speed."""

from dataclasses import dataclass

from cea.damping import RayleighDamping
from cea.errors import InputError
from cea.fields import Expression


@dataclass(frozen=True)
class DampingSpec:
    """Rayleigh damping of a body, C = alpha M + beta K: by its factors, or by damping ratios.

    Parameters
    ----------
    alpha
        Factor on the mass (1/s).
    beta
        Factor on the stiffness (s).
    ratios
        Damping ratios at two frequencies, given instead; 1 is critical.
    frequencies
        These frequencies (Hz).
    """

    alpha: float | None = None
    beta: float | None = None
    ratios: tuple[float, float] | None = None
    frequencies: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        by_factors = self.alpha is not None or self.beta is not None
        if by_factors == (self.ratios is not None):
            allowed = "alpha, beta or both; or ratios with frequencies"
            raise InputError("ratios", self.ratios, allowed)
        if (self.ratios is None) != (self.frequencies is None):
            raise InputError("frequencies", self.frequencies, "two where ratios are given")
        self.rayleigh()

    def rayleigh(self) -> RayleighDamping:
        """The damping as the system takes it."""
        if self.ratios is not None and self.frequencies is not None:
            return RayleighDamping.of_ratios(self.ratios, self.frequencies)
        return RayleighDamping(self.alpha or 0.0, self.beta or 0.0)


@dataclass(frozen=True)
class SlidingSpec:
    """What a contact does to small velocities because it slides at a speed.

    Each is a number or an expression in the coordinates.

    Parameters
    ----------
    pressure
        Contact pressure of steady sliding (N/m^2); left out where c_n makes it of the loads.
    speed
        Speed of sliding (m/s): friction that turns with the direction of sliding then damps motion
        across it, mu pressure / speed; in space only.
    mu_slope
        Derivative of mu in the speed (s/m), at constant pressure; below zero it feeds energy in.
    """

    pressure: float | str | None = None
    speed: float | str | None = None
    mu_slope: float | str | None = None

    def __post_init__(self) -> None:
        if isinstance(self.pressure, float) and not self.pressure >= 0:
            raise InputError("pressure", self.pressure, "greater than or equal to 0 (N/m^2)")
        if isinstance(self.speed, float) and not self.speed > 0:
            raise InputError("speed", self.speed, "greater than 0 (m/s)")
        if self.speed is None and self.mu_slope is None:
            raise InputError("speed", None, "speed, mu_slope or both")
        for name, value in self.fields.items():
            if isinstance(value, str):
                Expression(value).check(name)

    @property
    def fields(self) -> dict[str, float | str | None]:
        """What is given, and None for what is not, by name."""
        return {"pressure": self.pressure, "speed": self.speed, "mu_slope": self.mu_slope}
