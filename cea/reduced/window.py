"""What is looked at of a spectrum: frequencies up to an end, growth above a level."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.modes import uncertainties_of

MARGIN = 1.15
"""Frequency up to which modes are known beyond the window, relative to its end."""
_FURTHER = 0.05
"""Decay beyond that of the window, relative to its end, down to which eigenvectors are taken in."""
_DECAY = 0.1
"""Decay down to which modes are known with damping by default, relative to the window's end."""


@dataclass(frozen=True)
class Window:
    """What is looked at.

    Frequencies up to ``end`` (rad/s); z is lambda if ``damped``, else kappa = -lambda^2; growth
    above ``level`` (1/s) counts; modes are known down to ``decay`` (1/s).
    """

    end: float
    damped: bool
    level: float = 0.0
    decay: float = np.inf

    @classmethod
    def up_to(cls, max_frequency: float, *, damped: bool, decay: float | None = None) -> "Window":
        """That which ends at a frequency (Hz); all modes are known without damping."""
        end = 2 * np.pi * max_frequency
        known = _DECAY * end if decay is None else decay
        return cls(end, damped, decay=known if damped else np.inf)

    @property
    def max_frequency(self) -> float:
        """Its end (Hz)."""
        return self.end / (2 * np.pi)

    @property
    def reach(self) -> float:
        """Decay (1/s) down to which eigenvectors of damped pencils are taken into a basis."""
        return self.decay + _FURTHER * self.end

    @property
    def by_growth(self) -> bool:
        """Whether growth rates are compared with a level rather than pairs with a coalescence."""
        return self.damped or self.level != 0.0

    def roots(self, z: Complexes) -> Complexes:
        """The lambda of z; of kappa those with Im lambda >= 0, which grow where they are real."""
        if self.damped:
            return np.asarray(z, complex)
        root = np.sqrt(-np.asarray(z, complex))
        return np.where(root.imag < 0, -root, root) + 0j

    def root_slopes(self, z: Complexes, slopes: Complexes) -> Complexes:
        """Derivatives of lambda from those of z; infinite or NaN at a coalescence."""
        if self.damped:
            return slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            return -slopes / (2 * self.roots(z))

    def growth(self, z: Complexes) -> Floats:
        """Growth (1/s) above the level: of kappa that of the root that grows."""
        growth = self.roots(z).real
        return (growth if self.damped else np.abs(growth)) - self.level

    def doubts(self, z: Complexes, errors: Floats) -> Floats:
        """Errors of lambda (1/s) that errors of z make."""
        return errors if self.damped else uncertainties_of(self.roots(z), errors)

    def far(self, z: Complexes, part: float = 1.0) -> NDArray[np.bool_]:
        """Which lie beyond a part of the window, or decay too fast to be known."""
        roots = self.roots(z)
        return (np.abs(roots.imag) > part * self.end) | (roots.real < -self.decay)
