"""Window of a reduced model: frequencies up to an end, growth rates above a level."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.modes import uncertainties_of

MARGIN = 1.15
"""Largest frequency of modes in the basis relative to the end of the window."""
_FURTHER = 0.05
"""Margin of the decay rate of modes in the basis beyond that of the window, relative to its end."""
DECAY = 0.1
"""Default decay rate of a damped window relative to its end."""


@dataclass(frozen=True)
class Window:
    """A window of frequencies up to ``end`` (rad/s) and decay rates up to ``decay`` (1/s).

    Eigenvalues z are lambda if ``damped``, else kappa = -lambda^2. Modes count as growing if their
    growth rate is above ``level`` (1/s).
    """

    end: float
    damped: bool
    level: float = 0.0
    decay: float = np.inf

    @property
    def reach(self) -> float:
        """Largest decay rate (1/s) of eigenvectors of damped pencils in a basis."""
        return self.decay + _FURTHER * self.end

    @property
    def by_growth(self) -> bool:
        """Whether modes grow by their growth rate above the level, instead of by coalescence."""
        return self.damped or self.level != 0.0

    def roots(self, z: Complexes) -> Complexes:
        """Return lambda; of a kappa the root with Im lambda >= 0, or the positive real one."""
        if self.damped:
            return np.asarray(z, complex)
        root = np.sqrt(-np.asarray(z, complex))
        return np.where(root.imag < 0, -root, root) + 0j

    def root_slopes(self, z: Complexes, slopes: Complexes) -> Complexes:
        """Return derivatives of lambda from those of z; infinite or NaN at a coalescence."""
        if self.damped:
            return slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            return -slopes / (2 * self.roots(z))

    def growth(self, z: Complexes) -> Floats:
        """Return growth rates (1/s) minus the level; of a kappa that of its growing root."""
        growth = self.roots(z).real
        return (growth if self.damped else np.abs(growth)) - self.level

    def doubts(self, z: Complexes, errors: Floats) -> Floats:
        """Return errors of lambda (1/s) from errors of z."""
        return errors if self.damped else uncertainties_of(self.roots(z), errors)

    def far(self, z: Complexes, part: float = 1.0) -> NDArray[np.bool_]:
        """Return which z lie beyond ``part`` of the end, or decay faster than the window allows."""
        roots = self.roots(z)
        return (np.abs(roots.imag) > part * self.end) | (roots.real < -self.decay)
