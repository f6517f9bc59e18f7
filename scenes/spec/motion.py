"""What a scene says of small velocities: damping of bodies, contacts that slide at a speed."""

from dataclasses import dataclass

from cea.damping import ModalDamping, RayleighDamping
from cea.errors import InputError
from cea.expressions import Expression


@dataclass(frozen=True)
class DampingSpec:
    """Damping of a body: Rayleigh damping C = alpha M + beta K, modal damping, or both.

    The former is given by its factors, or by damping ratios.

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
    modal
        Damping ratios of the modes of the body alone.
    """

    alpha: float | None = None
    beta: float | None = None
    ratios: tuple[float, float] | None = None
    frequencies: tuple[float, float] | None = None
    modal: ModalDamping | None = None

    def __post_init__(self) -> None:
        ways = [self.alpha is not None or self.beta is not None, self.ratios is not None]
        if all(ways) or not (any(ways) or self.modal):
            allowed = "alpha, beta or both; or ratios with frequencies; modal, or it beside these"
            raise InputError("ratios", self.ratios, allowed)
        if (self.ratios is None) != (self.frequencies is None):
            raise InputError("frequencies", self.frequencies, "two where ratios are given")
        self.rayleigh()

    @property
    def acts(self) -> bool:
        """Whether anything is damped."""
        modal = self.modal is not None and self.modal.acts
        return modal or self.rayleigh() not in (None, RayleighDamping())

    @property
    def in_factors(self) -> "DampingSpec":
        """The same with factors of Rayleigh damping in the place of ratios, both where one is."""
        found = self.rayleigh()
        if found is None:
            return self
        return DampingSpec(found.alpha, found.beta, modal=self.modal)

    def rayleigh(self) -> RayleighDamping | None:
        """Rayleigh damping as the system takes it; None where there is modal damping alone."""
        if self.ratios is not None and self.frequencies is not None:
            return RayleighDamping.of_ratios(self.ratios, self.frequencies)
        if self.alpha is None and self.beta is None:
            return None
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
