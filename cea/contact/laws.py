"""Contact laws: pressure as a function of penetration, its slope, and sliding.

Laws are independent of geometry. After linearisation about steady sliding, the slope at the
penetrations of that state is the contact stiffness p, and friction multiplies it
(Mohanasundaram et al., 2023, eqs. 7, 8 and 16).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cea.arrays import Floats
from cea.errors import require


@dataclass(frozen=True)
class LinearLaw:
    """Pressure proportional to the penetration, also in tension: the closed region is known."""

    # contact stiffness p (N/m^3), shape (n,) or one number; zero where the sides are open; either
    # finite, or infinite at all points: the sides are then tied along the normal
    stiffness: Floats | float
    linear: ClassVar[bool] = True
    """The slope is constant: no steady sliding state is needed."""

    def __post_init__(self) -> None:
        p = np.asarray(self.stiffness)
        least, even = float(p.min(initial=np.inf)), bool(np.isinf(p).all() or not np.isinf(p).any())
        require(least >= 0, "p", least, "zero or positive (N/m^3)")
        some = bool(p.any()) or not p.size
        require(some, "p", 0.0, "positive (N/m^3) somewhere: else there is no contact")
        require(even, "p", np.inf, "finite, or infinite everywhere")

    def pressure(self, penetration: Floats) -> Floats:
        """Return the pressure (N/m^2) at each point for penetrations (m), shape (n,)."""
        return self.stiffness * penetration

    def slope(self, penetration: Floats) -> Floats:
        """Return the contact stiffness p (N/m^3), shape (n,)."""
        return np.broadcast_to(np.asarray(self.stiffness, dtype=float), penetration.shape)


@dataclass(frozen=True)
class NormalCompliance:
    """Normal compliance: the pressure c (g)_+^m, zero where the contact is open.

    Parameters
    ----------
    c
        c_n (N/m^(2 + m_n)), positive.
    m
        m_n, 1 or more.
    """

    c: float
    m: float
    linear: ClassVar[bool] = False

    def __post_init__(self) -> None:
        require(0 < self.c < np.inf, "c_n", self.c, "positive (N/m^(2 + m_n))")
        require(1 <= self.m < np.inf, "m_n", self.m, "1 or more")

    def pressure(self, penetration: Floats) -> Floats:
        """Return the pressure (N/m^2) at each point for penetrations (m), shape (n,)."""
        return self.c * np.maximum(penetration, 0.0) ** self.m

    def slope(self, penetration: Floats) -> Floats:
        """Return the contact stiffness p (N/m^3), zero where the contact is open, shape (n,)."""
        closed = np.maximum(penetration, 0.0)
        return np.where(penetration > 0, self.m * self.c * closed ** (self.m - 1), 0.0)

    def closure(self, pressure: float) -> float:
        """Return the penetration (m) for a pressure (N/m^2), zero or positive."""
        return float((pressure / self.c) ** (1 / self.m))


NormalLaw = LinearLaw | NormalCompliance
"""Law of the normal pressure."""


@dataclass(frozen=True)
class Sliding:
    """Sliding data for the damping of small velocities (:mod:`cea.system.contact_terms`)."""

    # v (m/s) at all points, shape (n,); None: no effect of the turning sliding direction
    speed: Floats | None = None
    mu_slope: Floats | None = None  # mu'(v) (s/m) at all points, shape (n,); None for zero
    # sigma (N/m^2) at all points, shape (n,); None: pressure of the law in the state
    pressure: Floats | None = None

    def __post_init__(self) -> None:
        if self.speed is not None:
            least = float(self.speed.min())
            require(least > 0, "sliding.speed", least, "positive (m/s)")
        if self.pressure is not None:
            least = float(self.pressure.min())
            require(least >= 0, "sliding.pressure", least, "zero or positive (N/m^2)")
